"""The page of the units that hydrofdi knows."""

from __future__ import annotations

from pathlib import Path

from generators.writing import table, write_page
from hydrofdi.units import BASE_UNITS, PREFIXABLE, PREFIXES, SPELLINGS, SYMBOLS, Unit

INTRODUCTION = """\
# Units

A quantity is a number and a unit, such as `551 MPa`, `0.12 L/min` or `22 µm/V`. A bare number is in SI. Units
are multiplied with `·`, `*` or a space and divided with `/`. Powers are `m²`, `m^2` or `m^1.5`; `√Hz` is
`Hz^0.5`. All factors are exact but that of the degree: every spelling of a quantity gives the same number.

Plans, checks and reports show a parameter in the unit that the experiment file uses: `bulk_modulus: 12000
bar` is shown in bar. The key `units` sets another one: `units: {fluid.bulk_modulus: GPa}`. Otherwise the unit
suits the size of the numbers. Leakage is shown in L/min. Files for programs (CSV, JSON, HDF5) always have the
same units, which stand in their headers.

"""

OTHERS = """\
## Other spellings

These are refused, and the message names the right unit: `did you mean 'L/min'?`. Upper and lower case differ:
`mPa` is a millipascal, `MPa` a megapascal.

"""

NAMES = {
    "K": "kelvin", "°C": "degree Celsius", "degC": "degree Celsius",
    "1": "without a unit", "%": "percent", "kg": "kilogram", "g": "gram", "t": "tonne", "lb": "pound",
    "m": "metre", "in": "inch", "ft": "foot", "s": "second", "min": "minute", "h": "hour",
    "day": "24 hours", "days": "24 hours", "exceldays": "days of a spreadsheet, from 1899-12-30",
    "µexceldays": "millionths of these", "FILETIME": "100 ns, from 1601-01-01",
    "Hz": "hertz, cycles per second", "rad": "radian", "deg": "degree", "°": "degree",
    "N": "newton", "daN": "decanewton",
    "kgf": "kilogram-force", "lbf": "pound-force", "Pa": "pascal", "hPa": "hectopascal", "atm": "atmosphere",
    "bar": "bar", "psi": "pound-force per square inch", "L": "litre", "l": "litre", "galUS": "US gallon",
    "galUK": "imperial gallon", "St": "stokes", "A": "ampere", "V": "volt", "J": "joule", "W": "watt",
}  # fmt: skip


def write(reference: Path) -> None:
    """Write ``reference/units.md``."""
    known = [
        (f"`{symbol}`", NAMES[symbol], _in_si(unit), _mark(symbol in PREFIXABLE))
        for symbol, unit in SYMBOLS.items()
    ]
    prefixes = [(f"`{prefix}`", f"10{_superscript(power)}") for prefix, power in PREFIXES.items()]
    parts = [
        INTRODUCTION + table(("unit", "name", "in SI", "takes a prefix"), known),
        "## Prefixes\n\n" + table(("prefix", "factor"), prefixes),
        OTHERS + _spellings(),
    ]
    write_page(reference / "units.md", "\n\n".join(parts) + "\n")


def _in_si(unit: Unit) -> str:
    bases = zip(BASE_UNITS, unit.exponents, strict=True)
    powers = [f"{base}{_superscript(int(power)) if power != 1 else ''}" for base, power in bases if power]
    return " ".join([f"{float(unit.factor):.7g}", "·".join(powers)]).strip()


def _spellings() -> str:
    rows = [(", ".join(names.split()), f"`{unit}`") for unit, names in SPELLINGS.items()]
    return table(("spelling, in any case", "stands for"), rows)


def _superscript(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _mark(holds: bool) -> str:
    return "yes" if holds else ""
