"""Expressions of units, such as ``N·s/m`` and ``m^3.5/kg^0.5``."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import lru_cache

from hydrofdi.units.symbols import PREFIXABLE, PREFIXES, SYMBOLS, Unit

_TOKEN = re.compile(r"\s*(?:([A-Za-zµμ%]+|1)|([·*/()])|\^(?a:(-?\d+(?:\.\d+)?|\(-?\d+/\d+\)))|([⁻⁰¹²³⁴-⁹]+))")
_ROOT = re.compile(r"(?:√|sqrt)\s*(?:\(\s*([A-Za-zµμ]+)\s*\)|([A-Za-zµμ]+))")
"""Square root of a single unit, as in ``Pa/√Hz`` or ``Pa/sqrt(Hz)``."""
_LARGEST_EXPONENT = 12
MOST_CHARACTERS = 100
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """The unit that an expression such as ``"N·s/m"``, ``"m^3.5/kg^0.5"`` or ``"Pa/√Hz"`` stands for.

    Raises
    ------
    ValueError
        The expression is malformed or names a unit that hydrofdi does not know.
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"a unit has at most {MOST_CHARACTERS} characters; found {len(text)}")
    result, power_sign, open_signs, pending = SYMBOLS["1"], 1, [1], None
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
