"""The channels that a record may have."""

from __future__ import annotations

from enum import StrEnum


class Channel(StrEnum):
    """A measured quantity of an actuator; the value is its name in files."""

    CHAMBER_1_PRESSURE = "chamber_1_pressure"
    CHAMBER_2_PRESSURE = "chamber_2_pressure"
    SUPPLY_PRESSURE = "supply_pressure"
    RETURN_PRESSURE = "return_pressure"
    PISTON_POSITION = "piston_position"
    PISTON_VELOCITY = "piston_velocity"
    SPOOL_POSITION = "spool_position"
    INPUT_VOLTAGE = "input_voltage"

    @property
    def unit(self) -> str:
        """SI unit."""
        return _UNITS[self.rpartition("_")[2]]

    @property
    def symbol(self) -> str:
        """Symbol in tables and in headers of plain files."""
        return _SYMBOLS[self]

    @property
    def is_pressure(self) -> bool:
        """Whether it is a pressure."""
        return self.unit == "Pa"


_SYMBOLS = {
    "chamber_1_pressure": "P1", "chamber_2_pressure": "P2", "supply_pressure": "Ps", "return_pressure": "Pr",
    "piston_position": "x", "piston_velocity": "v", "spool_position": "xv", "input_voltage": "u",
}  # fmt: skip

_UNITS = {"pressure": "Pa", "position": "m", "velocity": "m/s", "voltage": "V"}
