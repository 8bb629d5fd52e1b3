"""The channels that a record may have."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Any


class Channel(StrEnum):
    """A measured quantity of an actuator; the value is its name in files. The symbol is read as well."""

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

    @classmethod
    def _missing_(cls, value: object) -> Channel | None:
        return next((each for each in cls if each.symbol == value), None)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: Callable[[Any], Any]) -> dict[str, Any]:
        schema: dict[str, Any] = handler(core)
        own = handler.resolve_ref_schema(schema)  # type: ignore[attr-defined]
        own["enum"] = [*(each.value for each in cls), *(each.symbol for each in cls)]
        return schema

    @property
    def is_pressure(self) -> bool:
        """Whether it is a pressure."""
        return self.unit == "Pa"


_SYMBOLS = {
    "chamber_1_pressure": "P1", "chamber_2_pressure": "P2", "supply_pressure": "Ps", "return_pressure": "Pr",
    "piston_position": "x", "piston_velocity": "v", "spool_position": "xv", "input_voltage": "u",
}  # fmt: skip

_UNITS = {"pressure": "Pa", "position": "m", "velocity": "m/s", "voltage": "V"}
