"""Delimited text: CSV, TSV and whatever a logger writes."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array, Remark
from hydrofdi.records.measured.column_units import is_unit
from hydrofdi.records.measured.formats.table import Table
from hydrofdi.records.measured.formats.text_numbers import CellError, column_numbers, is_number
from hydrofdi.records.measured.sections import FormatConfig

_UNIT_APART = re.compile(r"(?<=\S)\s+(?=[\[(])")
"""Blanks between a name and its unit."""
_NAMED = {"tab": "\t", "\\t": "\t", "space": " "}


class TextTable(Table):
    """Columns of a delimited text."""

    def __init__(self, place: str, text: str, form: FormatConfig) -> None:
        self.place, self._form = place, form
        self._lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        kept = [self._lines[n] for n in self._kept()]
        self._is_blank_delimited = bool(kept) and self._delimiter(kept[:2]) == " "
        self._rows = self._split(kept)
        if not self._rows:
            raise DataError(f"{place}: holds no rows")
        self._first_row = 0
        self._units: list[str] = []
        self.titles = self._take_header()
        self._check_widths()
        self._leave_out_truncated(ends=text.endswith(("\n", "\r")))

    def unit(self, position: int) -> str:
        """Unit in the row of units, or in the header."""
        own = self._units[position].strip("[]() ") if position < len(self._units) else ""
        return own or super().unit(position)

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,)."""
        try:
            return column_numbers(self._cells(position), self._form.decimal, self._missing)
        except CellError as error:
            row = self._first_row + error.row
            hint = self._preamble_hint() if row == 0 else ""
            raise DataError(f"{self._at(row)}: column {self.titles[position]!r}: {error}{hint}") from None

    def text(self, position: int) -> str:
        """The one value of a column that does not change."""
        values = [cell.strip() for cell in self._cells(position)]
        for row, value in enumerate(values):
            if value != values[0]:
                at, title = self._at(self._first_row + row), self.titles[position]
                raise DataError(f"{at}: column {title!r} changes from {values[0]!r} to {value!r}")
        return values[0] if values else ""

    @property
    def _missing(self) -> Collection[str]:
        return self._form.missing

    def _kept(self) -> list[int]:
        comment, lines = self._form.comment or "\0", self._lines
        return [
            n
            for n in range(self._form.skip, len(lines))
            if lines[n].strip(" ") and not lines[n].lstrip().startswith(comment)
        ]

    def _split(self, lines: list[str]) -> list[list[str]]:
        delimiter = self._delimiter(lines[:2]) if lines else "\t"
        if delimiter == " ":
            return [_UNIT_APART.sub("", lines[0]).split(), *(line.split() for line in lines[1:])]
        reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
        try:
            rows = list(reader)
        except csv.Error as error:
            raise DataError(f"{self._at(reader.line_num - 1)}: {error}") from None
        if len(rows) != len(lines):
            raise DataError(f"{self.place}: a quoted cell goes over more than one line")
        return rows

    def _delimiter(self, first_lines: list[str]) -> str:
        given = self._form.delimiter
        if given is not None:
            return _NAMED.get(given, given)
        signs = [sign for sign in "\t;,|" if sign != self._form.decimal]
        found = next((sign for sign in signs if sign in first_lines[0]), None)
        return found or (" " if " " in first_lines[-1].strip() else "\t")

    def _take_header(self) -> list[str]:
        first = self._rows[0]
        numeric = [self._is_number(cell) for cell in first if cell.strip()]
        has_header = self._form.header
        if has_header is None:
            if any(numeric) and not all(numeric):
                raise DataError(
                    f"{self._at(0)}: is it a header or a row? Write 'format: {{header: true}}' or 'false'"
                    f"{self._preamble_hint()}"
                )
            has_header = not all(numeric)
        if not has_header:
            return [str(number + 1) for number in range(max(map(len, self._rows)))]
        self._first_row = 1
        if self._has_units_row():
            self._units, self._first_row = self._rows[1], 2
        titles = [cell.strip() for cell in first]
        while titles and not titles[-1]:
            titles.pop()
        return titles

    def _has_units_row(self) -> bool:
        if self._form.units_row is not None or len(self._rows) < 2:
            return bool(self._form.units_row) and len(self._rows) > 1
        cells = [cell.strip() for cell in self._rows[1] if cell.strip()]
        return bool(cells) and all(
            not self._is_number(cell) and is_unit(cell.strip("[]()")) for cell in cells
        )

    def _check_widths(self) -> None:
        width = len(self.titles)
        if self._is_blank_delimited and 0 < self._first_row < len(self._rows):
            self._check_blanks(len(self._rows[self._first_row]), width)
        if max(map(len, self._rows)) <= width:
            return
        for row in range(self._first_row, len(self._rows)):
            if any(cell.strip() for cell in self._rows[row][width:]):
                found = len(self._rows[row])
                hint = "; are commas decimal signs?" if "," in self._lines[self._kept()[row]] else ""
                raise DataError(f"{self._at(row)}: has {found} cells under {width} column names{hint}")

    def _check_blanks(self, found: int, width: int) -> None:
        if found != width:
            raise DataError(
                f"{self._at(self._first_row)}: has {found} cells under {width} column names; where names hold"
                " blanks, leave them out by 'format: {header: false, skip: …}' and give columns by number"
            )

    def _leave_out_truncated(self, ends: bool) -> None:
        rows = self._rows
        if not ends and len(rows) - self._first_row > 1 and len(rows[-1]) < len(rows[-2]):
            rows.pop()
            self.remarks = (Remark("truncated", "the last line is incomplete and left out"),)

    def _cells(self, position: int) -> list[str]:
        rows = self._rows[self._first_row :] if self._first_row else self._rows
        try:
            return [row[position] for row in rows]
        except IndexError:
            return [row[position] if position < len(row) else "" for row in rows]

    def _is_number(self, cell: str) -> bool:
        return is_number(cell, self._form.decimal, self._missing)

    def _at(self, row: int) -> str:
        return f"{self.place}:{self._kept()[row] + 1}"

    def _preamble_hint(self) -> str:
        return "; lines before the header are left out by 'format: {skip: …}'" if not self._form.skip else ""
