"""Numbers with units: text → SI → text."""

from __future__ import annotations

import math
import re
from fractions import Fraction

from hydrofdi.units.expressions import parse_unit
from hydrofdi.units.spellings import similar_units
from hydrofdi.units.symbols import Unit

_NUMBER = re.compile(r"\s*([-+]?(?:[0-9][0-9_]*\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*)", re.DOTALL)


class Quantity(float):
    """A number in SI that knows its unit.

    Attributes
    ----------
    unit : str
        ``""`` if it has none.
    """

    unit = ""

    @classmethod
    def of(cls, value: float, unit: str) -> Quantity:
        """A number in an SI unit."""
        quantity = cls(value)
        quantity.unit = unit
        return quantity

    def to(self, unit: str) -> float:
        """The number in another unit, e.g. ``"L/min"``.

        Raises
        ------
        ValueError
            The unit is unknown or has another dimension.
        """
        if _given_unit(unit, self.unit).exponents != parse_unit(self.unit or "1").exponents:
            raise ValueError(f"{unit} has the wrong dimension; it must be convertible to {self.unit or 1}")
        return convert(self, unit)


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
        The text is not a number with a unit, or the unit has another dimension.
    """
    match = _NUMBER.fullmatch(text)
    if match is None or match[2].startswith(","):
        comma = "a point instead of a comma, " if "," in text else "it "
        raise ValueError(f"{text!r} is not a number with a unit; write {comma}like {_example(text, unit)!r}")
    number, given = match.groups()
    wanted = parse_unit(unit)
    found = _given_unit(given.strip(), unit) if given.strip() else wanted
    if found.exponents != wanted.exponents:
        needed = "be a number or a percentage" if unit == "1" else f"be convertible to {unit}"
        raise ValueError(f"{text!r} has the wrong unit; it must {needed}")
    return _scaled(number, found.factor / wanted.factor)


def parse_si(text: str) -> float:
    """A quantity such as ``"551 MPa"`` in the SI unit of its dimension.

    Raises
    ------
    ValueError
        The text is not a number with a unit.
    """
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with a unit")
    number, unit = match.groups()
    factor = parse_unit(unit.strip()).factor if unit.strip() else Fraction(1)
    return _scaled(number, factor)


def stated_unit(text: str, unit: str) -> str | None:
    """The unit that a quantity is written with, such as ``bar`` in ``"80 bar"`` and ``"±5 bar"``.

    Parameters
    ----------
    text : str
    unit : str
        Unit of the same dimension.

    Returns
    -------
    str or None
        None if the text states no unit of this dimension.
    """
    match = _NUMBER.fullmatch(text.lstrip(" ±"))
    if match is None or not (given := match[2].strip()):
        return None
    try:
        return given if parse_unit(given).exponents == parse_unit(unit).exponents else None
    except ValueError:
        return None


def convert(value: float, unit: str) -> float:
    """A value in SI expressed in `unit`, e.g. ``convert(2e-6, "L/min")`` is 0.12.

    Non-finite values pass unchanged.
    """
    if not math.isfinite(value):
        return value
    return float(Fraction(value) / parse_unit(unit).factor)


def _given_unit(text: str, wanted: str) -> Unit:
    """The unit of a quantity; the error suggests units for an unknown spelling."""
    try:
        return parse_unit(text)
    except ValueError as error:
        similar = similar_units(text, wanted)
        hint = f"; did you mean {' or '.join(map(repr, similar))}?" if similar else ""
        raise ValueError(f"{error}{hint}") from None


def _example(text: str, unit: str) -> str:
    """The same with a decimal point, unless its comma may divide thousands; otherwise another quantity."""
    pointed = text.strip().replace(",", ".", 1)
    if re.search(r"\d,\d", text) and not re.search(r",\d{3}\b", text):
        match = _NUMBER.fullmatch(pointed)
        if match is not None and (not match[2] or stated_unit(pointed, unit)):
            return pointed
    return "1.5" if unit == "1" else f"1.5 {unit}"


def _scaled(number: str, factor: Fraction) -> float:
    if not 1e-300 < abs(float(number)) < 1e300:
        return float(number)
    try:
        return float(Fraction(number.replace("_", "")) * factor)
    except OverflowError:
        raise ValueError(f"{number!r} is too large a number in its unit") from None
