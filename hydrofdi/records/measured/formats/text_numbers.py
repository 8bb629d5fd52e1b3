"""Strict conversion of cells to numbers: a wrong format never passes as a number."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

import numpy as np

from hydrofdi.records.batch import Array
from hydrofdi.records.dates import Instant, instant, seconds_from_first

MISSING = frozenset({"", "nan", "na", "n/a", "null", "none"})
"""Texts in lower case that mean a missing value."""

_COMMA_INSIDE = re.compile(r"[-+]?[\d.]*,\d+([eE][-+]?\d+)?")


class CellError(ValueError):
    """A cell that is not a number.

    Attributes
    ----------
    row : int
        Row of the cell.
    message : str
        What is wrong with the cell.
    is_decimal_comma : bool
        Whether it is a number if its comma is a decimal sign.
    """

    def __init__(self, row: int, message: str, hint: str = "", *, is_decimal_comma: bool = False) -> None:
        self.row, self.message, self.is_decimal_comma = row, message, is_decimal_comma
        super().__init__(message + hint)


def column_numbers(cells: Sequence[str], decimal: str = ".", missing: Collection[str] = ()) -> Array:
    """The numbers in cells, shape (n_row,); NaN if one is missing.

    Raises
    ------
    CellError
        For the first cell that is neither a number nor missing.
    """
    joined = "\n".join(cells)
    simple = not missing and "_" not in joined and (decimal == "." or "." not in joined)
    if simple:
        plain = cells if decimal == "." else joined.replace(",", ".").split("\n")
        try:
            return np.fromiter(map(float, plain), np.float64, len(plain))
        except ValueError:
            pass
    return np.array(
        [_number(row, cell, decimal, missing) for row, cell in enumerate(cells)], dtype=np.float64
    )


def column_dates(cells: Sequence[str], missing: Collection[str] = ()) -> Array:
    """Time since the first of the dates in cells [s], shape (n_row,); NaN if one is missing.

    Raises
    ------
    CellError
        For the first cell that is neither a date nor missing.
    """
    found: list[Instant | None] = []
    for row, cell in enumerate(cells):
        try:
            found.append(None if is_missing(cell, missing) else instant(cell))
        except ValueError as error:
            raise CellError(row, str(error)) from None
    try:
        return seconds_from_first(found)
    except ValueError as error:
        raise CellError(0, str(error)) from None


def is_missing(cell: str, missing: Collection[str] = ()) -> bool:
    """Whether a cell means a missing value."""
    text = cell.strip()
    return text in missing or text.lower() in MISSING


def is_number(cell: str, decimal: str = ".", missing: Collection[str] = ()) -> bool:
    """Whether a cell is a number or missing."""
    try:
        _number(0, cell, decimal, missing)
    except CellError:
        return False
    return True


def _number(row: int, cell: str, decimal: str, missing: Collection[str]) -> float:
    text = cell.strip()
    if is_missing(text, missing):
        return float("nan")
    foreign = "_" if decimal == "." else "_."
    try:
        if any(sign in text for sign in foreign):
            raise ValueError
        return float(text if decimal == "." else text.replace(",", "."))
    except ValueError:
        is_comma = decimal == "." and _COMMA_INSIDE.fullmatch(text) is not None
        message = f"{text[:40]!r} is not a number"
        raise CellError(row, message, _hint(text, decimal, is_comma), is_decimal_comma=is_comma) from None


def _hint(text: str, decimal: str, is_decimal_comma: bool) -> str:
    if is_decimal_comma:
        return (
            "; if commas are decimal signs, write 'format: {decimal: \",\"}' in the YAML that describes"
            " the file (docs/measured.md)"
        )
    if decimal == "," and "." in text:
        return "; its point is not a decimal sign here, because 'decimal' is ','"
    return ""
