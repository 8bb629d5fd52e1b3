"""Quantities with units at the border, SI floats inside.

``"551 MPa"``, ``"0.12 L/min"`` and ``"22 µm/V"`` become floats in SI. All conversion factors are
exact fractions but that of the degree, so that every spelling of one quantity gives the same float.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import islice, product
from typing import Self

Exponents = tuple[Fraction, ...]

BASE_UNITS = ("kg", "m", "s", "A", "rad", "K")
"""Base units that span all dimensions; the angle is one, so that Hz and rad/s are not mixed up."""


@dataclass(frozen=True)
class Unit:
    """A unit as an exact (or, after a fractional power, rounded) factor and exponents of the base units."""

    factor: Fraction
    exponents: Exponents

    def __mul__(self, other: Self) -> Unit:
        exponents = tuple(a + b for a, b in zip(self.exponents, other.exponents, strict=True))
        return Unit(self.factor * other.factor, exponents)

    def __pow__(self, power: Fraction) -> Unit:
        exact = power.denominator == 1
        factor = self.factor**power.numerator if exact else Fraction(float(self.factor) ** float(power))
        return Unit(factor, tuple(exponent * power for exponent in self.exponents))


_POUND_FORCE = Fraction("0.45359237") * Fraction("9.80665")
_FACTORS: tuple[tuple[dict[str, int], dict[str, str | Fraction]], ...] = (
    ({}, {"1": "1", "%": "1/100"}),
    ({"kg": 1}, {"kg": "1", "g": "1/1000", "t": "1000", "lb": "0.45359237"}),
    ({"m": 1}, {"m": "1", "in": "0.0254", "ft": "0.3048"}),
    ({"s": 1}, {"s": "1", "min": "60", "h": "3600", "day": "86400", "days": "86400", "exceldays": "86400"}),
    ({"s": 1}, {"µexceldays": "0.0864", "FILETIME": "1/10000000"}),
    ({"s": -1}, {"Hz": "1"}),
    ({"rad": 1}, {"rad": "1", "deg": Fraction(math.pi) / 180, "°": Fraction(math.pi) / 180}),
    ({"kg": 1, "m": 1, "s": -2}, {"N": "1", "daN": "10", "kgf": "9.80665", "lbf": _POUND_FORCE}),
    ({"kg": 1, "m": -1, "s": -2}, {"Pa": "1", "hPa": "100", "atm": "101325", "bar": "100000"}),
    ({"kg": 1, "m": -1, "s": -2}, {"psi": _POUND_FORCE / Fraction("0.0254") ** 2}),
    ({"m": 3}, {"L": "1/1000", "l": "1/1000", "galUS": "0.003785411784", "galUK": "0.00454609"}),
    ({"m": 2, "s": -1}, {"St": "1/10000"}),
    ({"A": 1}, {"A": "1"}),
    ({"K": 1}, {"K": "1", "°C": "1", "degC": "1"}),
    ({"kg": 1, "m": 2, "s": -3, "A": -1}, {"V": "1"}),
    ({"kg": 1, "m": 2, "s": -2}, {"J": "1"}),
    ({"kg": 1, "m": 2, "s": -3}, {"W": "1"}),
)
"""Dimension → factors of its units."""

SYMBOLS = {
    symbol: Unit(Fraction(factor), tuple(Fraction(powers.get(base, 0)) for base in BASE_UNITS))
    for powers, factors in _FACTORS
    for symbol, factor in factors.items()
}
"""Symbol → unit."""

ZEROS = {"°C": 273.15, "degC": 273.15, "FILETIME": -11_644_473_600.0} | dict.fromkeys(
    ("exceldays", "µexceldays"), -2_209_161_600.0
)
"""Unit with another zero than SI → its zero, which columns and single quantities have, not differences. Times
count from 1970 inside, those of Windows from 1601 [100 ns], those of Excel from 1899-12-30 [days]."""
_ATMOSPHERE = 101_325.0
_REFERENCE = re.compile(
    r"(\w*(?:bar|psi))(?:(a)|g)|(\w*(?:bar|psi|Pa)) ?(?:\((?:(abs|a)|rel|g)\)| (?:(abs|a)|rel|g))"
)
"""Absolute and gauge pressure, as in bara, bar(a), psig, kPa abs."""


def zero_of(unit: str) -> float:
    """Zero of a unit in SI: of absolute pressure it is 1.01325 bar below that of the gauge inside."""
    named = _REFERENCE.fullmatch(unit.strip())
    return -_ATMOSPHERE if named and (named[2] or named[4] or named[5]) else ZEROS.get(unit.strip(), 0.0)


def gauge_unit(unit: str) -> str:
    """A unit of pressure without ``a`` or ``g``; any other as it is."""
    named = _REFERENCE.fullmatch(unit.strip())
    return named[1] or named[3] if named else unit


PREFIXABLE = {"g", "m", "s", "Hz", "N", "Pa", "L", "l", "A", "V", "J", "W", "psi", "bar", "St"}
PREFIXES = {"G": 9, "M": 6, "k": 3, "d": -1, "c": -2, "m": -3, "µ": -6, "μ": -6, "u": -6, "n": -9}
"""Powers of ten."""


_TOKEN = re.compile(
    r"\s*(?:([A-Za-zµμ%°]+|1)|([·*/()])|\^(?a:(-?\d+(?:\.\d+)?|\(-?\d+/\d+\)))|([⁻⁰¹²³⁴-⁹]+))"
)
_ROOT = re.compile(r"(?:√|sqrt)\s*(?:\(\s*([A-Za-zµμ]+)\s*\)|([A-Za-zµμ]+))")
"""Square root of a single unit, as in ``Pa/√Hz`` or ``Pa/sqrt(Hz)``."""
_LARGEST_EXPONENT = 12
MOST_CHARACTERS = 100
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """The unit that an expression such as ``"N·s/m"``, ``"m^3.5/kg^0.5"`` or ``"Pa/√Hz"`` stands for."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"a unit has at most {MOST_CHARACTERS} characters; found {len(text)}")
    result, power_sign, open_signs, pending = SYMBOLS["1"], 1, [1], None
    for symbol, operator, power in _tokens(_ROOT.sub(r"\1\2^0.5", gauge_unit(text))):
        if symbol:
            result = result if pending is None else result * pending
            pending = _symbol(symbol, text) ** Fraction(power_sign * open_signs[-1])
            power_sign = 1
        elif power:
            if pending is None:
                raise ValueError(f"misplaced exponent in the unit {text!r}")
            pending = pending ** _exponent(power, text)
        elif operator == "/":
            power_sign = -1
        elif operator == "(":
            open_signs.append(open_signs[-1] * power_sign)
            power_sign = 1
        elif operator == ")":
            if len(open_signs) == 1:
                raise ValueError(f"unbalanced parentheses in the unit {text!r}")
            open_signs.pop()
    if pending is None or len(open_signs) != 1 or power_sign != 1:
        raise ValueError(f"{text!r} is not a unit")
    return result * pending


def _tokens(text: str) -> list[tuple[str, str, str]]:
    tokens: list[tuple[str, str, str]] = []
    position = 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if match is None:
            raise ValueError(f"{text!r} is not a unit")
        symbol, operator, power, superscript = match.groups(default="")
        if (power or superscript) and tokens and tokens[-1][2]:
            raise ValueError(f"misplaced exponent in the unit {text!r}")
        tokens.append((symbol, operator, power.strip("()") or superscript.translate(_SUPERSCRIPTS)))
        position = match.end()
    return tokens


def _exponent(power: str, text: str) -> Fraction:
    try:
        exponent = Fraction(power)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f"{power!r} is not an exponent in the unit {text!r}") from None
    if abs(exponent) > _LARGEST_EXPONENT:
        raise ValueError(f"exponent {power} is too large in the unit {text!r}")
    return exponent


def _symbol(symbol: str, text: str) -> Unit:
    if symbol in SYMBOLS:
        return SYMBOLS[symbol]
    prefix, stem = symbol[0], symbol[1:]
    if prefix in PREFIXES and stem in PREFIXABLE:
        unit = SYMBOLS[stem]
        return Unit(unit.factor * Fraction(10) ** PREFIXES[prefix], unit.exponents)
    within = "" if symbol == text else f" in {text!r}"
    raise ValueError(f"unknown unit {symbol!r}{within}")


SPELLINGS = {
    "s": "sec secs second seconds sek sekunden", "ms": "msec milliseconds", "min": "minutes minuten",
    "µs": "usec microseconds", "h": "hr hour hours stunden", "Hz": "hertz cps", "1/min": "rpm",
    "in": "inch inches", "ft": "foot feet", "µm": "micron microns", "mm²": "sqmm", "cm³": "cc ccm",
    "L": "liter liters litre litres ltr", "L/min": "lpm", "mL/min": "mlpm", "galUS": "gal gallon gallons",
    "galUS/min": "gpm usgpm", "galUK/min": "gpm", "kgf": "kp", "lb": "lbs", "N·m": "nm",
    "bar": "bars", "kpsi": "ksi", "V": "volt volts", "A": "amp amps",
    "m/s": "mps", "%": "percent pct", "deg": "degree degrees",
}  # fmt: skip
"""Symbol or expression → other spellings, in small letters."""

_WORD = re.compile(r"[A-Za-zµμ]+")
_BARE_POWER = re.compile(r"(?<=[a-zA-Zµμ])(?:\*\*|\^)?([23])(?![\d.])")
_UNLIKELY = ("Mm", "Ms")
"""What capitals do not stand for: MM are millimetres."""
_KNOWN = [*SYMBOLS, *(prefix + stem for prefix in PREFIXES for stem in sorted(PREFIXABLE))]
_MOST_READINGS = 100


def similar_units(text: str, unit: str) -> list[str]:
    """Units of the dimension of `unit` that a spelling which `parse_unit` refuses may stand for."""
    plain = _BARE_POWER.sub(lambda power: "²³"[int(power[1]) - 2], text.strip(" .")[:MOST_CHARACTERS])
    plain = re.sub(r"(?<=\w)[-.](?=[A-Za-z])", "·", plain)
    pieces, words = _WORD.split(plain), _WORD.findall(plain)
    wanted, readings = parse_unit(unit).exponents, []
    for chosen in islice(product(*map(_meant, words)), _MOST_READINGS):
        reading = "".join(piece + word for piece, word in zip(pieces, [*chosen, ""], strict=True))
        try:
            if parse_unit(reading).exponents == wanted:
                readings.append(reading)
        except ValueError:
            continue
    return list(dict.fromkeys(readings))


def _meant(word: str) -> list[str]:
    """What one word of an expression may stand for; itself if it is known."""
    if word in _KNOWN:
        return [word]
    small = word.lower()
    if spelt := [unit for unit, names in SPELLINGS.items() if small in names.split()]:
        return spelt
    units = [known for known in _KNOWN if known.lower() == small and known not in _UNLIKELY]
    return [known for known in units if word != small and known[0] == word[0]] or units


_NUMBER = re.compile(r"\s*([-+]?(?:[0-9][0-9_]*\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*)", re.DOTALL)


def parse_quantity(text: str, unit: str) -> float:
    """A quantity such as ``"551 MPa"``, or a bare number, as a float in ``unit``."""
    match = _NUMBER.fullmatch(text)
    if match is None or match[2].startswith(","):
        example = "1.5" if unit == "1" else f"1.5 {unit}"
        raise ValueError(f"{text!r} is not a number with a unit; write it like {example!r}")
    wanted = parse_unit(unit)
    given = given_unit(match[2].strip() or unit, unit)
    if given.exponents != wanted.exponents:
        needed = "be a number or a percentage" if unit == "1" else f"be convertible to {unit}"
        raise ValueError(f"{text!r} has the wrong unit; it must {needed}")
    return _scaled(match[1], given.factor / wanted.factor) + zero_of(match[2])


def parse_si(text: str) -> float:
    """A quantity such as ``"551 MPa"`` in the SI unit of its dimension."""
    if (match := _NUMBER.fullmatch(text)) is None:
        raise ValueError(f"{text!r} is not a number with a unit")
    return _scaled(match[1], parse_unit(match[2].strip() or "1").factor)


def stated_unit(text: str, unit: str) -> str | None:
    """The unit that a quantity is written with, like ``bar`` in ``"±5 bar"``; None if of another kind."""
    match = _NUMBER.fullmatch(text.lstrip(" ±"))
    if match is None or not (given := match[2].strip()):
        return None
    try:
        return gauge_unit(given) if parse_unit(given).exponents == parse_unit(unit).exponents else None
    except ValueError:
        return None


def given_unit(text: str, wanted: str) -> Unit:
    """The unit of a quantity; the error suggests units for an unknown spelling."""
    try:
        return parse_unit(text)
    except ValueError as error:
        similar = similar_units(text[:MOST_CHARACTERS], wanted)
        hint = f"; did you mean {' or '.join(map(repr, similar))}?" if similar else ""
        raise ValueError(f"{error}{hint}") from None


def _scaled(number: str, factor: Fraction) -> float:
    if not 1e-300 < abs(float(number)) < 1e300:
        return float(number)
    try:
        return float(Fraction(number.replace("_", "")) * factor)
    except OverflowError:
        raise ValueError(f"{number!r} is too large a number in its unit") from None
