"""Quantities with units at the border, SI floats inside.

``"551 MPa"``, ``"0.12 L/min"`` and ``"22 µm/V"`` become floats in SI. All conversion factors are
exact fractions, so that every spelling of one quantity gives the same float.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Self

Exponents = tuple[Fraction, ...]

BASE_UNITS = ("kg", "m", "s", "A", "rad")
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


def _unit(factor: str | Fraction, **exponents: int) -> Unit:
    return Unit(Fraction(factor), tuple(Fraction(exponents.get(base, 0)) for base in BASE_UNITS))


_POUND_FORCE = Fraction("0.45359237") * Fraction("9.80665")
_NEWTON = _unit("1", kg=1, m=1, s=-2)
_PASCAL = _unit("1", kg=1, m=-1, s=-2)

_SYMBOLS = {
    "1": _unit("1"),
    "%": _unit("1/100"),
    "kg": _unit("1", kg=1),
    "g": _unit("1/1000", kg=1),
    "m": _unit("1", m=1),
    "in": _unit("0.0254", m=1),
    "s": _unit("1", s=1),
    "min": _unit("60", s=1),
    "h": _unit("3600", s=1),
    "Hz": _unit("1", s=-1),
    "rad": _unit("1", rad=1),
    "N": _NEWTON,
    "Pa": _PASCAL,
    "bar": Unit(Fraction(100_000), _PASCAL.exponents),
    "psi": Unit(_POUND_FORCE / Fraction("0.0254") ** 2, _PASCAL.exponents),
    "L": _unit("1/1000", m=3),
    "l": _unit("1/1000", m=3),
    "A": _unit("1", A=1),
    "V": _unit("1", kg=1, m=2, s=-3, A=-1),
    "J": _unit("1", kg=1, m=2, s=-2),
    "W": _unit("1", kg=1, m=2, s=-3),
}
_PREFIXABLE = {"g", "m", "s", "Hz", "N", "Pa", "L", "l", "A", "V", "J", "W", "psi", "bar"}
_PREFIXES = {"G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "µ": -6, "μ": -6, "u": -6, "n": -9}

_SPELLINGS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("usec", "µsec", "microseconds"), "us"),
    **dict.fromkeys(("minute", "minutes"), "min"),
    **dict.fromkeys(("barg", "bara", "bar(g)", "bar(a)", "bars"), "bar"),
    **dict.fromkeys(("psig", "psia"), "psi"),
    **dict.fromkeys(("volt", "volts"), "v"),
    **dict.fromkeys(("millimeter", "millimetre"), "mm"),
    **dict.fromkeys(("pascal", "pascals"), "pa"),
}
"""Other spellings, in small letters, of units that hydrofdi knows."""

_EXPRESSIONS = {
    **dict.fromkeys(("lpm", "l/m", "lmin", "l/minute"), "L/min"),
    **dict.fromkeys(("cc", "ccm"), "cm³"),
    **dict.fromkeys(("cc/min", "ml/minute", "mlpm"), "mL/min"),
    **dict.fromkeys(("percent", "pct"), "%"),
    **dict.fromkeys(("ns/m",), "N·s/m"),
    **dict.fromkeys(("m/sec", "mps"), "m/s"),
    **dict.fromkeys(("mm/sec",), "mm/s"),
}
"""Other spellings, in small letters, of expressions."""

_NUMBER = re.compile(r"\s*([-+]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)", re.DOTALL)
_TOKEN = re.compile(r"\s*(?:([A-Za-zµμ%]+|1)|([·*/()])|\^(-?\d+(?:\.\d+)?|\(-?\d+/\d+\))|([⁻⁰¹²³⁴-⁹]+))")
_ROOT = re.compile(r"(?:√|sqrt)\s*(?:\(\s*([A-Za-zµμ]+)\s*\)|([A-Za-zµμ]+))")
"""Square root of a single unit, as in ``Pa/√Hz`` or ``Pa/sqrt(Hz)``."""
_LARGEST_EXPONENT = 12
_BARE_POWER = re.compile(r"([a-zµμ])([23])(?![\d.])")
"""A power without its sign, as in ``cm2``."""
_RAISED = {"2": "²", "3": "³"}
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def parse_quantity(text: str, unit: str) -> float:
    """A quantity such as ``"551 MPa"`` as a float in ``unit``.

    Parameters
    ----------
    text : str
        A number, or a number and a unit of the same dimension as `unit`.
    unit : str
        Unit of the returned number, e.g. ``"Pa"``; also the unit of a bare number.

    Raises
    ------
    ValueError
        The text is no number with a unit, or the unit has another dimension.
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit; write it like '1.5 {unit}'")
    number, given = match.groups()
    wanted = parse_unit(unit)
    found = _given_unit(given.strip(), unit) if given.strip() else wanted
    if found.exponents != wanted.exponents:
        raise ValueError(f"{text!r} has the wrong unit; it must be convertible to {unit}")
    return _scaled(number, found.factor / wanted.factor)


def parse_si(text: str) -> float:
    """A quantity such as ``"551 MPa"`` in the SI unit of its dimension.

    Raises
    ------
    ValueError
        The text is no number with a unit.
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit")
    number, unit = match.groups()
    factor = parse_unit(unit.strip()).factor if unit.strip() else Fraction(1)
    return _scaled(number, factor)


def convert(value: float, unit: str) -> float:
    """A value in SI expressed in `unit`, e.g. ``convert(2e-6, "L/min")`` is 0.12.

    Non-finite values pass unchanged.
    """
    if not math.isfinite(value):
        return value
    return float(Fraction(value) / parse_unit(unit).factor)


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """The unit that an expression such as ``"N·s/m"``, ``"m^3.5/kg^0.5"`` or ``"Pa/√Hz"`` stands for.

    Raises
    ------
    ValueError
        The expression is malformed or names a unit that hydrofdi does not know.
    """
    result, power_sign, open_signs, pending = _SYMBOLS["1"], 1, [1], None
    for symbol, operator, power in _tokens(_ROOT.sub(r"\1\2^0.5", text)):
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
        raise _not_a_unit(text)
    return result * pending


def similar_units(text: str, unit: str) -> list[str]:
    """Units of the dimension of `unit` that an unknown spelling such as ``Bar`` or ``sec`` may stand for.

    Parameters
    ----------
    text : str
        A spelling that `parse_unit` refuses.
    unit : str
        A unit of the dimension that is wanted.
    """
    wanted = parse_unit(unit).exponents
    spellings = [*_SYMBOLS, *(prefix + stem for prefix in _PREFIXES for stem in sorted(_PREFIXABLE))]
    fitting = [spelling for spelling in spellings if parse_unit(spelling).exponents == wanted]
    letters = text.strip().rstrip(".").lower()
    expression = _EXPRESSIONS.get(letters, "1")
    if parse_unit(expression).exponents == wanted and expression != "1":
        return [expression]
    letters = _SPELLINGS.get(letters, letters)
    return [spelling for spelling in fitting if spelling.lower() == letters]


def _given_unit(text: str, wanted: str) -> Unit:
    """The unit of a quantity; what an unknown spelling may stand for is part of the error."""
    try:
        return parse_unit(text)
    except ValueError as error:
        similar = [] if "did you mean" in str(error) else similar_units(text, wanted)
        hint = f"; did you mean {' or '.join(map(repr, similar))}?" if similar else ""
        raise ValueError(f"{error}{hint}") from None


def _scaled(number: str, factor: Fraction) -> float:
    if not 1e-300 < abs(float(number)) < 1e300:
        return float(number)
    try:
        return float(Fraction(number.replace("_", "")) * factor)
    except OverflowError:
        raise ValueError(f"{number!r} is too large a number in its unit") from None


def _tokens(text: str) -> list[tuple[str, str, str]]:
    tokens: list[tuple[str, str, str]] = []
    position = 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if match is None:
            raise _not_a_unit(text)
        symbol, operator, power, superscript = match.groups(default="")
        if (power or superscript) and tokens and tokens[-1][2]:
            raise ValueError(f"misplaced exponent in the unit {text!r}")
        tokens.append((symbol, operator, power.strip("()") or superscript.translate(_SUPERSCRIPTS)))
        position = match.end()
    return tokens


def _not_a_unit(text: str) -> ValueError:
    """The error on what is no unit, with the spelling of a power that it may stand for."""
    power = _BARE_POWER.sub(lambda found: found[1] + _RAISED[found[2]], text)
    hint = f"; did you mean {power!r}?" if power != text and _is_known(power) else ""
    return ValueError(f"{text!r} is not a unit{hint}")


def _is_known(text: str) -> bool:
    try:
        parse_unit(text)
    except ValueError:
        return False
    return True


def _exponent(power: str, text: str) -> Fraction:
    try:
        exponent = Fraction(power)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f"{power!r} is no exponent in the unit {text!r}") from None
    if abs(exponent) > _LARGEST_EXPONENT:
        raise ValueError(f"exponent {power} is too large in the unit {text!r}")
    return exponent


def _symbol(symbol: str, text: str) -> Unit:
    if symbol in _SYMBOLS:
        return _SYMBOLS[symbol]
    prefix, stem = symbol[0], symbol[1:]
    if prefix in _PREFIXES and stem in _PREFIXABLE:
        unit = _SYMBOLS[stem]
        return Unit(unit.factor * Fraction(10) ** _PREFIXES[prefix], unit.exponents)
    within = "" if symbol == text else f" in {text!r}"
    raise ValueError(f"unknown unit {symbol!r}{within}")
