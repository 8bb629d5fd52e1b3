"""Delimited text: CSV, TSV and other files of loggers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.dates import is_dated
from hydrofdi.records.measured.column_names import is_unit
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.table import Table
from hydrofdi.records.measured.formats.text_cells import (
    CellError,
    Cells,
    column_dates,
    column_numbers,
    is_missing,
    is_number,
)


def broken_rows(widths: Sequence[int], n_column: int) -> list[int]:
    """Rows with fewer cells than usual in the file, which may leave its last column empty."""
    usual = _usual(widths, n_column)
    return [row for row, width in enumerate(widths) if width < usual]


def rows_to_keep(widths: Sequence[int], n_column: int, *, is_ended: bool) -> int:
    """Number of rows up to the last complete one; at least one.

    Parameters
    ----------
    widths : sequence of int
        Cells of each row.
    n_column : int
        Columns with a name.
    is_ended : bool
        Whether the last row has a line end.
    """
    usual, kept = _usual(widths, n_column), len(widths)
    if kept > 1 and not is_ended and widths[-1] < widths[-2]:
        kept -= 1
    while kept > 1 and widths[kept - 1] < usual:
        kept -= 1
    return kept


def bridged(times: Array, rows: Sequence[int]) -> Array:
    """Instants, interpolated linearly in some rows; NaN if a row has no neighbour on one side."""
    if not rows:
        return times
    whole = np.delete(np.arange(times.size), rows)
    times[rows] = np.interp(rows, whole, times[whole], left=np.nan, right=np.nan)
    return times


def _usual(widths: Sequence[int], n_column: int) -> int:
    """The most frequent number of cells, at most `n_column`; the larger of equally frequent numbers."""
    counts = Counter(widths)
    return min(n_column, max(counts, key=lambda width: (counts[width], width), default=0))


_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
_NEWEST = 1000
"""Number of last rows that are compared with each other."""


class TextTable(Table):
    """Columns of a delimited text.

    Raises
    ------
    DataError
        The header is ambiguous, or rows have more cells than there are column names.
    """

    def __init__(self, place: str, text: str, form: FormatConfig) -> None:
        self.place, self._form = place, form
        self._cells = Cells(place, text, form)
        if not self._cells.n_row:
            raise DataError(f"{place}: contains no rows")
        self._first_row, self._units = 0, [""]
        self.titles = self._take_header() if self._has_header() else self._numbered()
        self._check_widths()
        self._broken: list[int] = []
        self.remarks = tuple(self._irregularities(is_ended=text.endswith(("\n", "\r"))))

    @property
    def has_decimal_commas(self) -> bool:
        """Whether the first row has numbers with decimal commas, contrary to the description."""
        has_rows = self._form.decimal == "." and self._first_row < self._cells.n_row
        cells = self._cells.row(self._first_row) if has_rows else []
        return any(_COMMA_NUMBER.fullmatch(cell.strip()) for cell in cells)

    def unit(self, position: int) -> str:
        """Unit in the row of units, or in the header."""
        own = self._units[position].strip("[]() ") if position < len(self._units) else ""
        header = super().unit(position)
        if own and header and own != header:
            title = self.titles[position]
            raise DataError(f"{self._cells.place(1)}: column {title!r} has the unit {own} here")
        return own or header

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,)."""
        if self._matrix is not None:
            return np.ascontiguousarray(self._matrix[:, position])
        cells = self._cells.column(position, self._first_row)
        try:
            return column_numbers(cells, self._form.decimal, self._form.missing)
        except CellError as error:
            row = self._first_row + error.row
            hint = self._first_row_hint() if error.row == 0 else ""
            place, title = self._cells.place(row), self.titles[position]
            raise DataError(f"{place}: column {title!r}: {error}{hint}") from None

    def dates(self, position: int) -> Array | None:
        """Time since the first date of a column [s]; None if it contains no dates."""
        if self._matrix is not None:
            return None
        cells = self._cells.column(position, self._first_row)
        first = next((cell for cell in cells if not is_missing(cell, self._form.missing)), "")
        if not is_dated(first):
            return None
        try:
            return bridged(column_dates(cells, self._form.missing), self._broken)
        except CellError as error:
            place, title = self._cells.place(self._first_row + error.row), self.titles[position]
            raise DataError(f"{place}: column {title!r}: {error}") from None

    def instants(self, position: int) -> Array:
        """Values of a time column; truncated rows are interpolated between their neighbours."""
        return bridged(self.numbers(position), self._broken)

    def text(self, position: int) -> str:
        """The value of a constant column."""
        cells = enumerate(self._cells.column(position, self._first_row))
        values = {row: cell.strip() for row, cell in cells if row not in self._broken}
        first = next(iter(values.values()), "")
        for row, value in values.items():
            if value != first:
                place, title = self._cells.place(self._first_row + row), self.titles[position]
                raise DataError(f"{place}: column {title!r} changes from {first!r} to {value!r}")
        return first

    @cached_property
    def _matrix(self) -> Array | None:
        """All columns, if they contain only numbers that NumPy can read; else None."""
        is_usual = self._form.decimal == "." and not self._form.missing
        return self._cells.matrix(self._first_row, len(self.titles)) if is_usual else None

    def _has_header(self) -> bool:
        if self._form.header is not None:
            return self._form.header
        numeric = [self._is_number(cell) for cell in self._cells.row(0) if cell.strip()]
        if any(numeric) and not all(numeric):
            choice = "Write 'format: {header: true}' or 'false'"
            hint = self._preamble_hint()
            raise DataError(f"{self._cells.place(0)}: is this a header or a row? {choice}{hint}")
        return not all(numeric)

    def _numbered(self) -> list[str]:
        if self._cells.is_comma_doubtful:
            raise DataError(
                f"{self._cells.place(0)}: do commas separate columns, or are they decimal signs? Write"
                " 'format: {delimiter: \",\"}' or 'format: {decimal: \",\"}'"
            )
        return [str(number + 1) for number in range(self._cells.width)]

    def _take_header(self) -> list[str]:
        self._first_row = 1
        if self._has_units_row():
            self._units, self._first_row = self._cells.row(1), 2
        titles = [cell.strip() for cell in self._cells.row(0)]
        while titles and not titles[-1]:
            titles.pop()
        return titles

    def _has_units_row(self) -> bool:
        if self._form.units_row is not None or self._cells.n_row < 2:
            return bool(self._form.units_row) and self._cells.n_row > 1
        cells = [cell.strip() for cell in self._cells.row(1) if cell.strip()]
        return bool(cells) and all(
            not self._is_number(cell) and is_unit(cell.strip("[]()")) for cell in cells
        )

    def _check_widths(self) -> None:
        width, first = len(self.titles), self._first_row
        if self._cells.are_blank_delimited and 0 < first < self._cells.n_row:
            self._check_blanks(len(self._cells.row(first)), width)
        if self._cells.width <= width:
            return
        for row in range(first, self._cells.n_row):
            cells = self._cells.row(row)
            if any(cell.strip() for cell in cells[width:]):
                hint = "; are commas decimal signs?" if "," in self._cells.line(row) else ""
                hint += self._preamble_hint()
                place = self._cells.place(row)
                raise DataError(f"{place}: has {len(cells)} cells under {width} column names{hint}")

    def _check_blanks(self, found: int, width: int) -> None:
        if found != width:
            raise DataError(
                f"{self._cells.place(self._first_row)}: has {found} cells under {width} column names"
                f"{self._preamble_hint()}; if names contain spaces, write"
                " 'format: {header: false, skip: …}' and give columns by number"
            )

    def _irregularities(self, is_ended: bool) -> Iterator[Issue]:
        cells, first = self._cells, self._first_row
        widths = cells.widths(first)
        kept = rows_to_keep(widths, len(self.titles), is_ended=is_ended)
        for _ in widths[kept:]:
            cells.leave_out_last()
        if widths[kept:]:
            yield Issue("the last line is incomplete and is ignored", kind="truncated")
        elif not is_ended and self._may_be_cut():
            yield Issue("the last line has no line end; its last number may be cut off", kind="unended")
        if n_between := cells.lines_between(first):
            yield Issue(f"blank lines or comments between rows: {n_between}", kind="interrupted")
        self._broken = broken_rows(widths[:kept], len(self.titles))
        for row in self._broken:
            cells.empty(first + row)
        if n_short := sum(width < len(self.titles) for width in widths[:kept]):
            yield Issue(
                f"rows with fewer cells than there are column names: {n_short}{self._cut()}", kind="ragged"
            )

    def _may_be_cut(self) -> bool:
        """Whether the last cell may be an incomplete number: another cell of its column is longer."""
        rows = range(max(self._first_row, self._cells.n_row - _NEWEST), self._cells.n_row)
        lengths = [len(self._cells.row(row)[-1].strip()) for row in rows]
        return bool(lengths) and lengths[-1] < max(lengths)

    def _cut(self) -> str:
        if not self._broken:
            return ""
        line = self._cells.line_number(self._first_row + self._broken[0])
        return f"; {len(self._broken)} cut off and read as missing, the first in line {line}"

    def _is_number(self, cell: str) -> bool:
        return is_number(cell, self._form.decimal, self._form.missing)

    def _first_row_hint(self) -> str:
        units = "for a line of units, write 'format: {units_row: true}'"
        return f"; {units}" if self._first_row == 1 else self._preamble_hint()

    def _preamble_hint(self) -> str:
        return "" if self._form.skip else "; to skip lines before the header, write 'format: {skip: …}'"
