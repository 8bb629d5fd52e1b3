"""Numbers of windows in the units that a person uses."""

from __future__ import annotations

from hydrofdi.units import convert

_READABLE = {"Pa": "MPa", "m": "mm", "m/s": "mm/s", "m^3/s": "L/min", "m³/s": "L/min"}


_LEAST_PERCENT = 1e-4
"""Smaller shares have no digits that tell anything [%]."""


def percent(share: float) -> str:
    """A share as a percentage, with three digits and its sign."""
    return f"{percentage(share)} %"


def percentage(share: float) -> str:
    """The same without the sign, as the lower end of a range has it."""
    value = 100.0 * share
    return f"below {_LEAST_PERCENT:.4f}" if 0.0 < value < _LEAST_PERCENT else f"{value:.3g}"


def count_text(number: float) -> str:
    """How many on average, as a person says it."""
    return f"{number:,.0f}" if number >= 9.95 else f"{number:.2g}"


def time_text(seconds: float) -> str:
    """A duration in seconds, minutes or hours."""
    size, unit = (3600.0, "h") if seconds >= 3600.0 else (60.0, "min") if seconds >= 60.0 else (1.0, "s")
    value = seconds / size
    return f"{value:,.0f} {unit}" if value >= 999.5 else f"{value:.3g} {unit}"


def readable_unit(unit: str) -> str:
    """The unit that a person uses for one in SI."""
    return _READABLE.get(unit, unit)


def readable(value: float, unit: str) -> str:
    """A value in SI with four digits and the unit that a person uses."""
    shown = readable_unit(unit)
    number = f"{convert(value, shown) if shown != unit else value:.4g}"
    return number if shown == "1" else f"{number} {shown}"
