"""Numbers, shares, quantities and times as a person reads them."""

from __future__ import annotations

import math
import re
from typing import Any

from hydrofdi.units import ABOVE, convert

K_I_UNIT = "m^3.5/kg^0.5"
"""Unit of the leakage coefficient in base units."""

HOLE = "–"
"""What people read in place of a value that is missing."""

_LEAST_PERCENT = 1e-4
"""Percentage below which digits are meaningless [%]."""

_LEAST_PLAIN, _MOST_PLAIN = 1e-9, 1e9
"""Range of magnitudes written without an exponent."""

_READABLE = {
    "Pa": (("MPa", 1e6), ("kPa", 1e3)),
    "m^3/s": (("L/min", 0.0),),
    "m³/s": (("L/min", 0.0),),
    "m": (("m", 1.0), ("mm", 1e-4), ("µm", 0.0)),
    "m/s": (("m/s", 1.0), ("mm/s", 0.0)),
    "m^2": (("mm^2", 0.0),),
    "m^3": (("cm^3", 0.0),),
    "s": (("s", 0.1), ("ms", 0.0)),
    "N": (("kN", 1e4), ("N", 0.0)),
    "N/m": (("MN/m", 1e7), ("kN/m", 1e4), ("N/m", 0.0)),
    "m/V": (("µm/V", 0.0),),
    "Pa/V": (("MPa/V", 1e6), ("kPa/V", 0.0)),
    "rad": (("deg", 0.0),),
}
"""SI unit → units that a person reads, and from which size on."""


def readable_unit(own: str, largest: float) -> str:
    """The unit in which a person reads numbers up to `largest` [in `own`, SI]; `own` where there is none."""
    units = _READABLE.get(own, ())
    if units and largest == 0.0:
        return own if own in dict(units) else units[-1][0]
    return next((unit for unit, least in units if ABOVE * largest >= least), own)


def written_units(own: str) -> list[str]:
    """Units in which people write a quantity of an SI unit, the most usual first."""
    read = (unit for unit, _ in _READABLE.get(own, ()) if unit != own)
    return [*dict.fromkeys(({"Pa": "bar", "K": "°C"}.get(own, own), *read, own))]


def shown_quantity(value: float, own: str, stated: str = "") -> str:
    """A value in SI in a unit that is stated, or else in one that suits it, such as ``8.6 MPa``."""
    unit = stated if stated not in ("", own) else readable_unit(own, abs(value))
    number = number_text(convert(value, unit) if unit != own else value)
    return number if unit == "1" else f"{number} {typeset(unit)}"


def number_text(value: Any, n_digit: int = 4, scale: float = 1.0) -> str:
    """A value as people read it: four digits, no exponents up to 10 million, a dash if it is missing."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return HOLE
    if not isinstance(value, float):
        return str(value)
    scaled = value * scale
    is_whole = 10.0**n_digit - 0.5 <= abs(scaled) < 1e7
    return f"{scaled:.0f}" if is_whole else f"{scaled:.{n_digit}g}"


def typeset(unit: str) -> str:
    """A unit as it is printed: ``N·s/m`` for ``N*s/m``, ``µm`` for ``um``, ``m³/s/√Pa`` for that of K_i."""
    printed = re.sub(r"\bu(?=[A-Za-z])", "µ", unit).replace("*", "·").replace(K_I_UNIT, "m³/s/√Pa")
    return re.sub(r"\^([23])(?![\d.])", lambda power: "²" if power[1] == "2" else "³", printed)


def shown_bytes(count: int) -> str:
    """A size such as ``0.9 MB`` or ``66.8 GB``."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.1f} MB"


def percent(share: float) -> str:
    """A fraction as a percentage with three digits and the percent sign."""
    return f"{percentage(share)} %"


def percentage(share: float) -> str:
    """The same without the percent sign, e.g. for the lower end of a range."""
    value = 100.0 * share
    return f"below {_LEAST_PERCENT:.4f}" if 0.0 < value < _LEAST_PERCENT else f"{value:.3g}"


def plain(value: float, n_digit: int) -> str:
    """A number with `n_digit` significant digits; only extreme values have an exponent."""
    if not value or not _LEAST_PLAIN <= abs(value) < _MOST_PLAIN:
        return f"{value:.{n_digit}g}"
    import numpy as np

    return np.format_float_positional(value, n_digit, unique=False, fractional=False, trim="-")


def count_text(number: float) -> str:
    """A mean count, rounded for reading."""
    return f"{number:,.0f}" if number >= 9.95 else plain(number, 2)


def time_text(seconds: float) -> str:
    """A duration in seconds, minutes or hours."""
    size, unit = (3600.0, "h") if seconds >= 3600.0 else (60.0, "min") if seconds >= 60.0 else (1.0, "s")
    value = seconds / size
    return f"{value:,.0f} {unit}" if value >= 999.5 else f"{value:.3g} {unit}"


def two_digits(value: float) -> str:
    """A number with two digits, never as a power of ten where it has up to six."""
    return f"{float(f'{value:.2g}'):g}"


SUPPLY_PRESSURE = ("0.1 MPa", "150 MPa")
RETURN_PRESSURE = ("1 kPa", "20 MPa")
POSITION = ("1 µm", "10 m")
SPOOL_POSITION = ("1 µm", "50 mm")
VOLTAGE = ("10 mV", "1 kV")
