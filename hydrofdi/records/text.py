"""Delimited text of loggers, read in blocks, and tables with a row for each value."""

from __future__ import annotations

import gzip
import math
import re
from array import array
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from io import TextIOWrapper
from itertools import chain, dropwhile, islice
from pathlib import Path

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records import Array
from hydrofdi.records.columns import MOST_BYTES, FileColumns, RejectionError, channel_named, damage_named
from hydrofdi.records.description import FormatConfig, LongConfig
from hydrofdi.records.rows import FOOT_HINT, HEAD_HINT, Reading, RowReader, require_text, runs, wrong_encoding
from hydrofdi.records.times import Instant, is_dated, since_first, titles_of_time

_BLOCK = 2**21
_LONGEST_LINE = 2**26
_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
_OTHER_NUMBER = re.compile(r"[-+\u2212]?\d[\d.,' \u00a0\u202f]*([eEdD][-+]?\d+)?")
"""A number in any format."""
_NO_NUMBER = re.compile(r": '[^\d']+' is not a number$")
_MOST_COLUMNS = 16_384
"""As in a sheet of Excel."""
_SOME = 1000
"""Number of first rows that show the usual width."""


def blocks_of(path: Path, place: str, encoding: str) -> Iterator[list[str]]:
    """Lines of a file, block by block; the last line is empty if the one before has a line end."""
    is_packed, rest, text = path.suffix.lower() == ".gz", "", "\n"
    is_utf_8 = encoding.lower() in ("utf-8", "utf8")
    reader = gzip.open if is_packed else open
    with damage_named("gzip" if is_packed else "a file"), reader(path, "rb") as file:
        if not (head := file.peek(8)):
            raise RejectionError("empty", "is empty")
        if is_utf_8:
            require_text(place, head)
        reading = TextIOWrapper(file, "utf-8-sig" if is_utf_8 else encoding)
        while text:
            try:
                text = reading.read(_BLOCK)
            except UnicodeError:
                raise wrong_encoding(place, encoding) from None
            if file.tell() > MOST_BYTES:
                raise DataError(f"{path}: is larger than {MOST_BYTES / 2**30:g} GiB")
            if "\0" in text:
                raise DataError(f"{place}: is not text in {encoding}; is it a binary file, or in utf-16?")
            *lines, rest = (rest + text).split("\n")
            if len(rest) > _LONGEST_LINE:
                raise DataError(f"{place}: has a line of more than {_LONGEST_LINE:,} characters")
            yield lines if text else [*lines, rest]


class TextTable(FileColumns):
    """Columns of a delimited text; `blocks` gives all its lines, as `blocks_of`, each time it is called.

    Only its beginning is read at first, the rest when columns are loaded.

    Rows may have fewer cells than there are names. Those with fewer than usual at the beginning of the file
    are cut off: none of their numbers is believed.
    """

    def __init__(self, place: str, form: FormatConfig, blocks: Callable[[], Iterator[list[str]]]) -> None:
        self.place, self._form, self._blocks = place, form, blocks
        self._columns: dict[int, array[float]] = {}
        self._n_row, self._broken = 0, list[int]()
        self._since: Instant | None = None
        self._dates: tuple[int | None, str, int | None] = None, "", None
        kept = self._beginning()
        if kept and (stated := re.fullmatch(r'"?sep=(.)"?\s*', kept[0][1], re.IGNORECASE)):
            form, kept = form.model_copy(update={"delimiter": form.delimiter or stated[1]}), kept[1:]
            self._form = form
        if not kept:
            raise DataError(f"{place}: contains no rows")
        self._rows = RowReader(form, [line for _, line in kept[:2]], place)
        if (n_column := kept[0][1].count(self._rows.delimiter) + 1) > _MOST_COLUMNS:
            raise DataError(f"{place}: has {n_column:,} columns; export {_MOST_COLUMNS:,} of them at most")
        kept = [row for row in kept if not self._rows.is_empty(row[1])]
        self._lines, texts = [number for number, _ in kept], [line for _, line in kept]
        cells = self._cells_of(texts)
        try:
            has_names = self._rows.has_names(cells[0])
        except ValueError as error:
            raise DataError(f"{self._place(0)}: {error}{HEAD_HINT}") from None
        self._n_head = has_names + (has_names and len(cells) > 1 and self._rows.are_units(cells[1]))
        self.titles = self._rows.header(texts[0]) if self._n_head else self._numbered(texts, cells)
        self._rows.titles = self.titles
        self._rows.units = cells[1] if self._n_head > 1 else []
        self.example = cells[self._n_head :]
        if form.units_in_cells and self.example:
            self._rows.units = [self._rows.unit_of_cell(cell) for cell in self.example[0]]
        widths = Counter(map(len, self.example))
        usual = max(widths, key=lambda width: (widths[width], width), default=0)
        self._usual = min(len(self.titles), usual)
        if self._n_head and self.example:
            self._check_first(self.example[0])

    def clocks(self, time: int | None = None) -> Mapping[int, int]:
        """Columns to the right of one of several columns of time with one name belong to it."""
        titles = self.titles
        same = [n for n, title in enumerate(titles) if time is not None and title == titles[time]]
        named = titles_of_time(self) if time is None else same
        if len(named) < 2 or len({self.titles[n] for n in named}) > 1:
            return {}
        steps = {n: self._first_step(n) for n in named}
        others = [n for n in range(len(self.titles)) if n not in named and n > named[0]]
        times = {n: max(own for own in named if own < n) for n in others}
        return dict(sorted(times.items(), key=lambda item: steps[item[1]]))

    def _first_step(self, position: int) -> float:
        with suppress(ValueError, IndexError):
            first, second = (self._rows.number(position, row[position]) for row in self.example[:2])
            return second - first
        return math.inf

    @property
    def first_numeric(self) -> tuple[int, list[str]] | None:
        """Line and cells of the first row of numbers and dates alone, as any format writes them."""
        for row, cells in enumerate(self.example):
            if any(map(str.strip, cells)) and all(map(self._is_value, filter(str.strip, cells))):
                return self._lines[self._n_head + row], cells
        return None

    @property
    def n_between(self) -> int:
        """Number of lines with cells between the header, with its units, and the first row of numbers."""
        first = self.first_numeric
        return 0 if first is None else self._lines.index(first[0]) - self._n_head

    def _is_value(self, cell: str) -> bool:
        is_plain = self._rows.is_number(cell) or is_dated(cell) or self._rows.unit_of_cell(cell)
        return bool(is_plain or _OTHER_NUMBER.fullmatch(cell.strip()))

    def lines_above(self, line: int) -> list[list[str]]:
        """Cells of the lines above a line, those next to it first."""
        above = next(self._blocks())[: line - 1]
        return [self._rows.cells([text])[0] for text in reversed(above) if text.count('"') % 2 == 0]

    @property
    def units_in_cells(self) -> bool:
        """Whether all cells of the first row are numbers with units, and not plain ones."""
        row = [cell for cell in self.example[0] if cell.strip()] if self.example else []
        return bool(row) and all(map(self._rows.unit_of_cell, row))

    def tokens(self, known: Collection[str]) -> list[str]:
        """Which of the known texts stand in cells anywhere, as they are written."""
        tokens: dict[str, None] = {}
        for _, lines in self._row_blocks():
            for _, cells in runs(lines, self._rows.cells):
                texts = chain.from_iterable([] if isinstance(cells, ValueError) else cells)
                tokens |= dict.fromkeys(text.strip() for text in texts if text.strip().lower() in known)
        return [text for text in tokens if not self._rows.is_number(text)]

    @property
    def has_decimal_commas(self) -> bool:
        """Whether the first row of numbers has decimal commas, contrary to the description."""
        first = self.first_numeric or (0, next(iter(self.example), []))
        return self._form.decimal == "." and any(_COMMA_NUMBER.fullmatch(cell.strip()) for cell in first[1])

    @property
    def has_numbers(self) -> bool:
        """Whether the last rows that were looked at have a number or a date."""
        return any(self._is_value(cell) for row in self.example[-2:] for cell in row if cell.strip())

    def unit(self, position: int) -> str:
        """Unit in the row of units, or in the header."""
        try:
            return self._rows.unit(position)
        except ValueError as error:
            raise DataError(f"{self._place(1)}: {error}") from None

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,)."""
        if position not in self._columns:
            self.load([position])
        return np.frombuffer(self._columns.pop(position))[: self._n_row]

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, in which cut rows are interpolated, and the first date."""
        times, rows = self.numbers(position), self._broken
        if rows:
            whole = np.delete(np.arange(times.size), rows)
            times[rows] = np.interp(rows, whole, times[whole], left=np.nan, right=np.nan)
        return since_first(self._since if self.is_dated(position) else None, times)

    def date_by(self, position: int, form: str, date: int | None) -> None:
        """Read dates of a column in a stated format, after those of the column `date`."""
        self._dates = position, form, date

    def texts(self, position: int) -> list[str]:
        """All cells of a column, of rows that are not cut off."""
        rows = (self._rows.cells([line])[0] for _, line in self._row_lines())
        return [cells[position].strip() for cells in rows if len(cells) >= max(1, self._usual)]

    def load(self, positions: Sequence[int]) -> None:
        """Read columns, all in one pass."""
        dated = filter(self.is_dated, positions)
        reading = Reading(self._rows, self._usual, positions, dated, self._dates[1:])
        is_unended = False
        for number, lines in self._row_blocks():
            is_unended = not self._rows.is_empty(lines[-1])
            for row, parsed in runs(lines, reading.parse):
                if not isinstance(parsed, ValueError):
                    reading.add(*parsed, number + row)
                elif self._rows.is_empty(lines[row]):
                    reading.n_waiting += 1
                else:
                    is_value = str(parsed).startswith("column")
                    is_foot = _NO_NUMBER.search(str(parsed))
                    hint = HEAD_HINT if not (is_value and reading.n_row) else FOOT_HINT if is_foot else ""
                    raise DataError(f"{self.place}:{number + row}: {parsed}{hint}")
        self.remarks = tuple(reading.remarks(is_unended))
        self._n_row, self._broken = reading.n_row, reading.broken
        self._columns |= reading.columns
        self._since = reading.since or self._since

    def _beginning(self) -> list[tuple[int, str]]:
        """Numbers from 1, and texts, of the first lines with cells."""
        lines: list[str] = []
        kept: list[tuple[int, str]] = []
        reader, skip = RowReader(self._form, [], self.place), self._form.skip
        for block in self._blocks():
            lines += block
            kept = [(n, line) for n, line in enumerate(lines[skip:], skip + 1) if not reader.is_empty(line)]
            if len(kept) > 3:
                break
        return [*dropwhile(lambda row: not row[1].strip(), kept)][:_SOME]

    def _cells_of(self, texts: list[str]) -> list[list[str]]:
        """Cells of the first lines."""
        rows: list[list[str]] = []
        for row, cells in runs(texts, self._rows.cells):
            if isinstance(cells, ValueError):
                raise DataError(f"{self._place(row)}: {cells}")
            rows += cells
        rows[0] = self._rows.header(texts[0]) if self._rows.delimiter == " " else rows[0]
        return rows

    def _row_blocks(self) -> Iterator[tuple[int, list[str]]]:
        """Blocks of lines below the header, each with the number of its first line."""
        number = 1
        first = self._lines[self._n_head] if self._n_head < len(self._lines) else self._lines[-1] + 1
        for lines in self._blocks():
            start = max(0, first - number)
            if lines[start:]:
                yield number + start, lines[start:]
            number += len(lines)

    def row_place(self, row: int) -> str:
        """File and line of a row, and of the first line for -1."""
        numbers = (number for number, _ in self._row_lines())
        return (
            f"{self.place}:{self._lines[0] if row < 0 else next(islice(numbers, row, None), self._lines[-1])}"
        )

    def _row_lines(self) -> Iterator[tuple[int, str]]:
        """Lines of rows with their numbers."""
        for number, block in self._row_blocks():
            yield from (line for line in enumerate(block, number) if not self._rows.is_empty(line[1]))

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        if position == self._dates[0]:
            return True
        cells = (row[position] for row in self.example if position < len(row))
        return is_dated(next((cell for cell in cells if not self._rows.is_missing(cell)), ""))

    def _numbered(self, texts: list[str], cells: list[list[str]]) -> list[str]:
        is_stated = bool({"delimiter", "decimal"} & self._form.model_fields_set)
        if not is_stated and self._rows.delimiter == "," and not any("." in line for line in texts):
            raise DataError(
                f"{self._place(0)}: do commas separate columns, or are they decimal signs? Write"
                " 'format: {delimiter: \",\"}' or 'format: {decimal: \",\"}'"
            )
        return [str(number + 1) for number in range(max(map(len, cells)))]

    def _check_first(self, cells: list[str]) -> None:
        n_cell, n_title, are_blank_divided = len(cells), len(self.titles), self._rows.delimiter == " "
        if any(cell.strip() for cell in cells[n_title:]) or (are_blank_divided and n_cell != n_title):
            hint = "; are commas decimal signs?" if self.has_decimal_commas else ""
            if are_blank_divided:
                hint += "; for names with spaces write 'format: {header: false}' and number the columns"
            place = self._place(self._n_head)
            raise DataError(f"{place}: has {n_cell} cells under {n_title} column names{hint}{HEAD_HINT}")

    def _place(self, row: int) -> str:
        return f"{self.place}:{self._lines[row]}"


_WINCC = ("VarName", "Time_ms", "Time_ms [µexceldays]")
"""Columns of WinCC: its ``Time_ms`` counts millionths of a day from 1899-12-30."""


class LongTable(FileColumns):
    """The columns of a text whose rows have a name and a value: those of each name, with their own times.

    Titles are the names, then the columns beside name and value, once for each name. A name is that behind
    its last point or slash, if that is one of a channel.
    """

    def __init__(self, text: TextTable, form: LongConfig) -> None:
        self.place, self._text, self._read = text.place, text, dict[int, tuple[Array, float]]()
        name, value = text.find(form.name), text.find(form.value)
        names = np.array(text.texts(name))
        counts = Counter(names.tolist())
        ordered = sorted(counts, key=lambda each: (-counts[each], each))
        rows = [np.flatnonzero(names == each) for each in ordered]
        beside = [n for n in range(len(text.titles)) if n not in (name, value)]
        self._n_name, self._n_beside, self._n_row = len(ordered), len(beside), names.size
        self._places = [(value, own) for own in rows] + [(column, own) for own in rows for column in beside]
        is_wincc = _WINCC[0] in text.titles
        titles = [_WINCC[2] if is_wincc and text.titles[n] == _WINCC[1] else text.titles[n] for n in beside]
        later = [f"{title} of {each}" for each in ordered[1:] for title in titles]
        self.titles = [*map(last_part, ordered), *titles, *later]

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return position >= self._n_name and self._text.is_dated(self._places[position][0])

    def clocks(self, time: int | None = None) -> dict[int, int]:
        """Position of each name → its column like the column `time` of the most frequent name."""
        return {} if time is None else {n: time + n * self._n_beside for n in range(self._n_name)}

    def numbers(self, position: int) -> Array:
        """Values of a name, or of a column beside it."""
        return self.instants(position)[0]

    def instants(self, position: int) -> tuple[Array, float]:
        """The same, and the first date of the file."""
        column, rows = self._places[position]
        if column not in self._read:
            self._read[column] = self._text.instants(column)
        values, since = self._read[column]
        if values.size != self._n_row:
            raise DataError(f"{self.place}: rows are cut off")
        return values[rows], since

    def date_by(self, position: int, form: str, date: int | None) -> None:
        """Read dates in a stated format."""
        self._text.date_by(self._places[position][0], form, None if date is None else self._places[date][0])


def last_part(name: str) -> str:
    """What stands behind the last point or slash of a name, if that is the name of a channel."""
    last = name.replace("/", ".").rpartition(".")[2].strip("'\" ")
    return last if channel_named(last, "") else name
