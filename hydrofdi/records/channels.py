"""The channels that a record may have."""

from __future__ import annotations

from enum import StrEnum


class Channel(StrEnum):
    """A measured quantity of an actuator; its value is its name in files."""

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
    def is_pressure(self) -> bool:
        """Whether it is a pressure."""
        return self.unit == "Pa"


_UNITS = {"pressure": "Pa", "position": "m", "velocity": "m/s", "voltage": "V"}
