"""Units that hydrofdi knows by their symbols, with exact factors."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
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

SYMBOLS = {
    "1": _unit("1"),
    "%": _unit("1/100"),
    "kg": _unit("1", kg=1),
    "g": _unit("1/1000", kg=1),
    "t": _unit("1000", kg=1),
    "lb": _unit("0.45359237", kg=1),
    "m": _unit("1", m=1),
    "in": _unit("0.0254", m=1),
    "ft": _unit("0.3048", m=1),
    "s": _unit("1", s=1),
    "min": _unit("60", s=1),
    "h": _unit("3600", s=1),
    "day": _unit("86400", s=1),
    "days": _unit("86400", s=1),
    "Hz": _unit("1", s=-1),
    "rad": _unit("1", rad=1),
    "N": _NEWTON,
    "daN": _unit("10", kg=1, m=1, s=-2),
    "kgf": _unit("9.80665", kg=1, m=1, s=-2),
    "lbf": Unit(_POUND_FORCE, _NEWTON.exponents),
    "Pa": _PASCAL,
    "hPa": Unit(Fraction(100), _PASCAL.exponents),
    "atm": Unit(Fraction(101_325), _PASCAL.exponents),
    "bar": Unit(Fraction(100_000), _PASCAL.exponents),
    "psi": Unit(_POUND_FORCE / Fraction("0.0254") ** 2, _PASCAL.exponents),
    "L": _unit("1/1000", m=3),
    "l": _unit("1/1000", m=3),
    "galUS": _unit("0.003785411784", m=3),
    "galUK": _unit("0.00454609", m=3),
    "St": _unit("1/10000", m=2, s=-1),
    "A": _unit("1", A=1),
    "V": _unit("1", kg=1, m=2, s=-3, A=-1),
    "J": _unit("1", kg=1, m=2, s=-2),
    "W": _unit("1", kg=1, m=2, s=-3),
}
"""Symbol → unit."""

PREFIXABLE = {"g", "m", "s", "Hz", "N", "Pa", "L", "l", "A", "V", "J", "W", "psi", "bar", "St"}
PREFIXES = {"G": 9, "M": 6, "k": 3, "d": -1, "c": -2, "m": -3, "µ": -6, "μ": -6, "u": -6, "n": -9}
"""Powers of ten."""
