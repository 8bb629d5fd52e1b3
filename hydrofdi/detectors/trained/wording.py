"""Numbers of windows in the units that a person uses."""

from __future__ import annotations

from hydrofdi.units import convert

_READABLE = {"Pa": "MPa", "m": "mm", "m/s": "mm/s", "m^3/s": "L/min", "m³/s": "L/min"}


def readable_unit(unit: str) -> str:
    """The unit that a person uses for one in SI."""
    return _READABLE.get(unit, unit)


def readable(value: float, unit: str) -> str:
    """A value in SI with four digits and the unit that a person uses."""
    shown = readable_unit(unit)
    number = f"{convert(value, shown) if shown != unit else value:.4g}"
    return number if shown == "1" else f"{number} {shown}"
