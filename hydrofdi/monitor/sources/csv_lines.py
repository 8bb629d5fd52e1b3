"""Lines of delimited text as samples."""

from __future__ import annotations

import csv
from collections.abc import Collection, Sequence
from itertools import chain

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.columns import Columns, columns_of
from hydrofdi.monitor.sources.contract import malformed
from hydrofdi.monitor.sources.payload import SampleClock
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.dates import is_dated, unix_seconds
from hydrofdi.records.measured.column_names import is_unit
from hydrofdi.records.measured.formats.text_cells import (
    CellError,
    blank_divided,
    column_numbers,
    delimiter_of,
    is_number,
)
from hydrofdi.records.streams import Chunk


class CsvLines:
    """Reads a header, an optional row of units, and rows.

    Blocks of lines are read at once. A block with a line that is not a row is halved until that line is
    found: it is a comment, a repeated header, or malformed.

    Attributes
    ----------
    header : list of str
        The lines that are needed to continue within the stream.
    """

    def __init__(
        self,
        config: MonitorConfig,
        clock: SampleClock | None,
        name: str,
        needed: Collection[Channel] = (),
    ) -> None:
        self.header: list[str] = []
        self._channels, self._time, self._clock = config.channels, config.time, clock
        self._form = config.format
        self._name, self._needed = name, needed
        self._delimiter, self._titles = ",", list[str]()
        self._units: list[str] | None = None
        self._columns: Columns | None = None
        self._zone, self._has_begun = config.time_zone, False
        self._reason = ""

    def read(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines.

        Raises
        ------
        DataError
            The first line is not a usable header.
        """
        if not lines:
            return []
        if self._columns is not None and (chunk := self._block(lines, self._columns)) is not None:
            return [chunk]
        if len(lines) == 1:
            return self._line(lines[0])
        middle = len(lines) // 2
        return self.read(lines[:middle]) + self.read(lines[middle:])

    def _block(self, lines: Sequence[str], columns: Columns) -> Chunk | None:
        """Samples of lines; None if one of them is not a row."""
        try:
            cells, width = self._cells(lines)
            self._check_width(cells, width)
            values = {
                channel: column.in_si(self._numbers(cells[column.position :: width]))
                for channel, column in columns.channels.items()
            }
            return Chunk(self._times(columns, cells, width, len(lines)), values)
        except CellError as error:
            self._reason = error.message + (_comma_hint() if error.is_decimal_comma else "")
        except (ValueError, csv.Error) as error:
            self._reason = _reason(error)
        return None

    def _cells(self, lines: Sequence[str]) -> tuple[list[str], int]:
        """All cells of lines with equal numbers of cells, and that number."""
        text = self._delimiter.join(lines)
        comment = self._form.comment
        if comment and comment in text and (len(lines) > 1 or text.lstrip().startswith(comment)):
            raise ValueError("is a comment")
        if self._delimiter == " ":
            rows = [line.split() for line in lines]
        elif '"' in text:
            rows = list(csv.reader(lines, delimiter=self._delimiter, skipinitialspace=True))
        else:
            widths = {line.count(self._delimiter) for line in lines}
            return text.split(self._delimiter), _only(widths) + 1
        if len(rows) != len(lines):
            raise ValueError("a quoted cell extends over more than one line")
        return list(chain.from_iterable(rows)), _only({len(row) for row in rows})

    def _check_width(self, cells: Sequence[str], width: int) -> None:
        n_title = len(self._titles)
        extra = chain.from_iterable(cells[column::width] for column in range(n_title, width))
        if width < n_title or any(not cell.isspace() for cell in extra if cell):
            raise ValueError(f"has {width} cells under {n_title} column names")
        if width == 1 and not all(map(str.strip, cells)):
            raise ValueError("is blank")

    def _numbers(self, cells: Sequence[str]) -> Array:
        return column_numbers(cells, self._form.decimal, self._form.missing)

    def _times(self, columns: Columns, cells: Sequence[str], width: int, n_time: int) -> Array:
        if columns.time is None:
            assert self._clock is not None
            return self._clock.take(n_time)
        texts = cells[columns.time.position :: width]
        return (
            unix_seconds(texts, self._zone)
            if is_dated(texts[0])
            else columns.time.in_si(self._numbers(texts))
        )

    def _line(self, line: str) -> list[Chunk]:
        """Read a line that is not a row, or the first after a header."""
        text = line.strip("\r ")
        comment = self._form.comment
        if not text.strip() or (comment and text.startswith(comment)):
            return []
        try:
            if not self._titles:
                self._begin(text)
                return []
            if self._columns is None:
                return self._first_after_header(text)
            if self._is_header(text):
                self._begin(text)
            else:
                return [self._refused(text, self._reason)]
        except (ValueError, csv.Error) as error:
            if not self._has_begun:
                raise (
                    error
                    if isinstance(error, DataError)
                    else DataError(f"{self._name}: {text[:60]!r} {_reason(error)}")
                ) from None
            self._titles, self.header, self._columns = [], [], None
            return [self._refused(text, _reason(error))]
        return []

    def _begin(self, text: str) -> None:
        """Take a line as the header."""
        self._delimiter = delimiter_of([text], self._form)
        titles = self._titles_in(text)
        if any(self._is_number(title) for title in titles if title):
            raise DataError(
                f"{self._name}: begins with {text[:60]!r}, which is not a header; write the names"
                " and units of the columns first, such as 'time [s],P1 [bar]'"
            )
        self._titles, self._units, self.header, self._columns = titles, None, [text], None

    def _titles_in(self, text: str) -> list[str]:
        cells = blank_divided(text) if self._delimiter == " " else self._cells([text])[0]
        titles = [cell.strip() for cell in cells]
        while titles and not titles[-1]:
            titles.pop()
        return titles

    def _first_after_header(self, text: str) -> list[Chunk]:
        cells = self._cells([text])[0]
        found = [cell.strip(" []()\r") for cell in cells]
        stated = [cell for cell in found if cell]
        is_row_of_units = stated and all(is_unit(cell) and not self._is_number(cell) for cell in stated)
        if is_row_of_units and self._units is None:
            self._units = (found + [""] * len(self._titles))[: len(self._titles)]
            self.header.append(text)
            return []
        self._columns = columns_of(
            self._titles,
            self._name,
            self._channels,
            self._time,
            self._units,
            self._needed,
            self._dated(cells),
        )
        if self._columns.time is None and self._clock is None:
            raise DataError(
                f"{self._name}: has no column of time such as 'time [s]'; add it, or give the sampling"
                " frequency"
            )
        self._has_begun = True
        return self.read([text])

    def _dated(self, cells: Sequence[str]) -> Collection[int]:
        """Columns of the first row without numbers; none if a sampling frequency replaces unnamed dates."""
        if self._clock is not None and self._time is None:
            return ()
        return [n for n in range(len(self._titles)) if n >= len(cells) or not self._is_number(cells[n])]

    def _refused(self, text: str, reason: str) -> Chunk:
        if self._clock is not None:
            self._clock.skip(1)
        return malformed("line", text, reason)

    def _is_header(self, text: str) -> bool:
        """Whether a line names columns, some of them known from the header before."""
        try:
            titles = self._titles_in(text)
        except (ValueError, csv.Error):
            return False
        return not any(map(self._is_number, filter(None, titles))) and bool(set(titles) & set(self._titles))

    def _is_number(self, cell: str) -> bool:
        return is_number(cell, self._form.decimal, self._form.missing)


def _reason(error: Exception) -> str:
    """Why a line is not a row, also for errors of the CSV library."""
    return "cannot be split into cells" if isinstance(error, csv.Error) else str(error)


def _only(numbers: set[int]) -> int:
    if len(numbers) != 1:
        raise ValueError("rows have different numbers of cells")
    return numbers.pop()


def _comma_hint() -> str:
    return "; if commas are decimal signs, write 'format: {decimal: \",\"}' in the file of config"
