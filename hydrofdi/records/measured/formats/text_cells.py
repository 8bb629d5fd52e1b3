"""A text divided into lines and cells."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Sequence
from functools import cached_property

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array
from hydrofdi.records.dates import Instant, instant, seconds_from_first
from hydrofdi.records.measured.description.sections import FormatConfig

_MOST_TOGETHER = 32
"""Most columns that are read all at once; of wider files, only the wanted columns are read."""
_NAMED = {"tab": "\t", "\\t": "\t", "space": " "}
_UNIT_APART = re.compile(r"(?<=\S)\s+(?=[\[(])")
"""Blanks between a name and its unit."""


class Cells:
    """Cells of the lines that are neither blank nor comments.

    Attributes
    ----------
    n_row : int
    width : int
        Most cells of a row.
    are_blank_delimited : bool
        Whether runs of blanks separate the cells.

    Raises
    ------
    DataError
        A line cannot be divided into cells.
    """

    def __init__(self, place: str, text: str, form: FormatConfig) -> None:
        self._place = place
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        self._numbers = _kept(lines, form)
        self._lines = lines if len(self._numbers) == len(lines) else [lines[n] for n in self._numbers]
        self.n_row = len(self._lines)
        self._delimiter = delimiter_of(self._lines[:2], form)
        self._is_guessed = form.delimiter is None
        self.are_blank_delimited = self._delimiter == " "
        self._rows = [] if self._is_even('"' in text) else self._divided()
        self.width = max(map(len, self._rows or [self.row(0)])) if self._lines else 0

    def row(self, number: int) -> list[str]:
        """Cells of a row."""
        return self._rows[number] if self._rows else self._lines[number].split(self._delimiter)

    def column(self, position: int, first_row: int) -> list[str]:
        """Cells of a column from a row on; empty if a row is too short."""
        if not self._rows:
            return self._flat[first_row * self.width + position :: self.width]
        rows = self._rows[first_row:]
        return [row[position] if position < len(row) else "" for row in rows]

    def matrix(self, first_row: int, n_column: int) -> Array | None:
        """All numbers from a row on, read at once; None if a cell is not a number, or columns are many."""
        if self._rows or first_row >= self.n_row or n_column > _MOST_TOGETHER:
            return None
        try:
            columns = range(n_column)
            lines = self._lines[first_row:]
            return np.loadtxt(lines, comments=None, delimiter=self._delimiter, usecols=columns, ndmin=2)
        except ValueError:
            return None

    @cached_property
    def _flat(self) -> list[str]:
        return self._delimiter.join(self._lines).split(self._delimiter)

    @property
    def is_comma_doubtful(self) -> bool:
        """Whether commas between integers may be decimal signs: no delimiter is stated, and no dot occurs."""
        return self._is_guessed and self._delimiter == "," and not any("." in line for line in self._lines)

    def lines_between(self, first_row: int) -> int:
        """Number of lines without cells among the rows from one on."""
        numbers = self._numbers[first_row : self.n_row]
        return numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0

    def widths(self, first_row: int) -> list[int]:
        """Number of cells of each row from one on; empty if all rows have equally many."""
        return [len(row) for row in self._rows[first_row:]]

    def empty(self, number: int) -> None:
        """Remove the cells of a row, but keep the row."""
        self._rows[number] = []

    def leave_out_last(self) -> None:
        """Remove the last row."""
        self._rows.pop()
        self.n_row -= 1

    def place(self, number: int) -> str:
        """File and line of a row."""
        return f"{self._place}:{self.line_number(number)}"

    def line_number(self, number: int) -> int:
        """Line of a row, from 1."""
        return self._numbers[number] + 1

    def line(self, number: int) -> str:
        """A row as it is written."""
        return self._lines[number]

    def _is_even(self, has_quotes: bool) -> bool:
        """Whether all rows have the same number of delimiters, and no quotes."""
        if self.are_blank_delimited or has_quotes:
            return False
        return len({line.count(self._delimiter) for line in self._lines}) == 1

    def _divided(self) -> list[list[str]]:
        if self.are_blank_delimited:
            return [blank_divided(self._lines[0]), *(line.split() for line in self._lines[1:])]
        reader = csv.reader(self._lines, delimiter=self._delimiter, skipinitialspace=True)
        try:
            rows = list(reader)
        except csv.Error:
            raise DataError(f"{self.place(reader.line_num - 1)}: cannot be split into cells") from None
        if len(rows) != len(self._lines):
            raise DataError(f"{self._place}: a quoted cell extends over more than one line")
        return rows


def _kept(lines: list[str], form: FormatConfig) -> list[int]:
    """Positions of the lines that contain cells."""
    comment = form.comment or "\0"
    return [
        n
        for n, line in enumerate(lines[form.skip :], form.skip)
        if (stripped := line.strip(" ")) and not stripped.startswith(comment)
    ]


def blank_divided(header: str) -> list[str]:
    """Titles of a header with blanks between them; a unit in brackets belongs to the title before it."""
    return _UNIT_APART.sub("", header).split()


def delimiter_of(first_lines: list[str], form: FormatConfig) -> str:
    """The delimiter, as stated or as in the first line; a blank for runs of blanks."""
    if form.delimiter is not None:
        return _NAMED.get(form.delimiter, form.delimiter)
    signs = [sign for sign in "\t;,|" if sign != form.decimal]
    found = next((sign for sign in signs if sign in "".join(first_lines[:1])), None)
    return found or (" " if " " in "".join(first_lines[-1:]).strip() else "\t")


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
