"""Delimited text → numbers, for files and streams alike. What is no number is refused, never guessed."""

from __future__ import annotations

import codecs
import csv
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TypeVar

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records import Array
from hydrofdi.records.columns import Titled, is_unit, split_title
from hydrofdi.records.description import FormatConfig
from hydrofdi.records.times import Instant, instant, seconds_since

Parsed = TypeVar("Parsed")

_NAMED = {"tab": "\t", "\\t": "\t", "space": " "}
_UNIT_APART = re.compile(r"(?<=\S)\s+(?=[\[(])")
"""Blanks between a name and its unit."""
_MISSING = frozenset({"", "nan", "na", "n/a", "null", "none"})
"""Texts in lower case that mean a missing value."""
_LIKE = (
    "1.#qnan -1.#qnan 1.#ind -1.#ind 1.#inf -1.#inf nan(ind) -nan(ind) -nan #n/a #nv #value! #div/0! <na> nat"
    " ol -ol ovl ofl overflow overrange bad invalid error --- -- - ? undefined unavailable unknown"
)
MISSING_LIKE = frozenset(_LIKE.split(" "))
"""Texts in lower case that programs write for missing values; a description must say that they mean that."""
_FORTRAN = re.compile(r"([-+]?\d*\.?\d*)[dD]([-+]?\d+)")
_WITH_UNIT = re.compile(r"\s*([-+]?[\d.,' ]*\d(?:[eE][-+]?\d+)?)\s*([^\d\s].*?)\s*")
_AROUND = "[]() \r"
"""What may stand around a unit."""
UNENDED = "the last line has no line end; its last number may be cut off"
HEAD_HINT = (
    "; 'hydrofdi inspect FILE --write rig.yaml' writes a description: 'format: {skip: …}' skips lines before"
    " the header, 'format: {units_row: true}' reads a line of units"
)
FOOT_HINT = "; lines that are no rows are passed over if 'format: {comment: …}' states how they begin"
_UTF_16 = "UTF-16; 'iconv -f UTF-16 -t UTF-8' converts it"
_BINARY = {
    **dict.fromkeys((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE), _UTF_16),
    b"PK\3\4": "a ZIP archive, as workbooks (.xlsx) are; export it as CSV",
    b"\x89HDF": "HDF5; name it .h5",
    b"PAR1": "Parquet; name it .parquet",
    b"\x1f\x8b": "compressed; name it .gz, or decompress it",
}
"""First bytes → what they mean."""
_COMMA_INSIDE = re.compile(r"[-+]?[\d.]*,\d+([eE][-+]?\d+)?")


def require_text(place: str, data: bytes) -> None:
    """Refuse a file or a stream that begins as no text does."""
    for begin, what in _BINARY.items():
        if data.startswith(begin):
            raise DataError(f"{place}: is not text but {what}")


def wrong_encoding(place: str, encoding: str) -> DataError:
    """The error that a text has another encoding."""
    return DataError(f"{place}: is not text in {encoding}; write 'format: {{encoding: …}}', such as cp1252")


class RowReader(Titled):
    """Reads lines under a header; the first lines show the delimiter if the format does not state it.

    A blank stands for runs of blanks. `titles` and `units`, the cells of a row of units, are set from
    outside.
    """

    units: Sequence[str] = ()

    def __init__(self, form: FormatConfig, first_lines: Sequence[str], place: str) -> None:
        super().__init__(place, [])
        self._form = form
        self.delimiter = _NAMED.get(form.delimiter or "", form.delimiter) or _delimiter_of(first_lines, form)

    def is_empty(self, line: str) -> bool:
        """Whether a line is blank or a comment; delimiters alone are a row of empty cells."""
        text, comment = line.strip(" \r"), self._form.comment
        is_blank = not (text if self.delimiter == "\t" else text.strip())
        return is_blank or bool(comment and text.startswith(comment))

    def header(self, line: str) -> list[str]:
        """Names in a line, without empty ones at the end."""
        if self.delimiter == " ":
            return _UNIT_APART.sub("", line).split()
        names = [cell.strip() for cell in self.cells([line])[0]]
        while names and not names[-1]:
            names.pop()
        return names

    def has_names(self, cells: Sequence[str]) -> bool:
        """Whether cells are the names of columns, as the format states or else as they look."""
        numeric = [self.is_number(cell) for cell in cells if cell.strip()]
        if self._form.header is None and any(numeric) and not all(numeric):
            raise ValueError("is this a header or a row? Write 'format: {header: true}' or 'false'")
        return not all(numeric) if self._form.header is None else self._form.header

    def are_units(self, cells: Sequence[str]) -> bool:
        """Whether cells below names are units, as the format states or else as they look."""
        units = [cell.strip() for cell in cells if cell.strip()]
        are_units = all(not self.is_number(cell) and is_unit(cell.strip(_AROUND)) for cell in units)
        return bool(units) and are_units if self._form.units_row is None else self._form.units_row

    def unit(self, position: int) -> str:
        """Unit of a column in the row of units, or else in its name; empty if neither states one."""
        own = self.units[position].strip(_AROUND) if position < len(self.units) else ""
        named = split_title(self.titles[position])[1]
        if own and named and own != named:
            raise ValueError(f"column {self.titles[position]!r} has the unit {own} below its name")
        return own or named

    def cells(self, lines: Sequence[str]) -> list[list[str]]:
        """Cells of each line."""
        if self.delimiter == " ":
            return [line.split() for line in lines]
        if not any('"' in line for line in lines):
            return [line.split(self.delimiter) for line in lines]
        try:
            rows = list(csv.reader(lines, delimiter=self.delimiter, skipinitialspace=True))
        except csv.Error:
            raise ValueError("cannot be split into cells") from None
        if len(rows) != len(lines) or any(line.count('"') % 2 for line in lines):
            raise ValueError("a quoted cell extends over more than one line")
        return rows

    def width(self, lines: Sequence[str]) -> int:
        """Number of cells of each line."""
        comment, n_title, text = self._form.comment, len(self.titles), "\n".join(lines)
        if comment and comment in text and any(line.lstrip(" ").startswith(comment) for line in lines):
            raise ValueError("is a comment")
        if self.delimiter == " " or '"' in text:
            widths = {len(row) for row in self.cells(lines)}
        else:
            widths = {line.count(self.delimiter) + 1 for line in lines}
        if len(widths) > 1:
            raise ValueError("rows have different numbers of cells")
        width = widths.pop()
        if width <= 1 and not all(map(str.strip, lines)):
            raise ValueError("is blank")
        if width > n_title and any(cell.strip() for row in self.cells(lines) for cell in row[n_title:]):
            hint = "; are commas decimal signs?" if "," in lines[0] and self._form.decimal == "." else ""
            raise ValueError(f"has {width} cells under {n_title} column names{hint}")
        return width

    def unit_of_cell(self, cell: str) -> str:
        """The unit at the end of a number; empty if there is none."""
        match = _WITH_UNIT.fullmatch(cell)
        return match[2] if match and is_unit(match[2]) else ""

    def numbers(self, lines: Sequence[str], positions: Sequence[int]) -> list[Array]:
        """Numbers of columns of rows of the same width, each of shape (n_line,); NaN if one is missing."""
        text, form = "\n".join(lines), self._form
        if positions and not form.missing and '"' not in text and (form.decimal == "." or "." not in text):
            plain = lines if form.decimal == "." else text.replace(",", ".").split("\n")
            delimiter = None if self.delimiter == " " else self.delimiter
            try:
                matrix = np.loadtxt(
                    plain, comments=None, delimiter=delimiter, usecols=positions, unpack=True, ndmin=2
                )
            except ValueError:
                pass
            else:
                if matrix.shape[1] == len(lines):
                    return [np.ascontiguousarray(row) for row in matrix]
        columns = zip(positions, self.texts(lines, positions), strict=True)
        return [np.array([self.number(position, cell) for cell in texts]) for position, texts in columns]

    def texts(self, lines: Sequence[str], positions: Sequence[int]) -> list[list[str]]:
        """Cells of columns; empty if a row is too short."""
        rows = self.cells(lines) if positions else []
        return [[row[position] if position < len(row) else "" for row in rows] for position in positions]

    def is_number(self, cell: str) -> bool:
        """Whether a cell is a number or missing."""
        try:
            self.number(None, cell)
        except ValueError:
            return False
        return True

    def is_missing(self, cell: str) -> bool:
        """Whether a cell means a missing value."""
        text = cell.strip()
        return text in self._form.missing or text.lower() in _MISSING

    def number(self, position: int | None, cell: str) -> float:
        """The number in a cell; NaN if it is missing."""
        text, decimal = cell.strip().replace("\u2212", "-"), self._form.decimal
        if self.is_missing(text):
            return float("nan")
        if self._form.units_in_cells and position is not None and (unit := self.units[position]):
            text = text.removesuffix(unit).rstrip() if text.endswith(unit) else f"{text} without {unit}"
        if (sign := self._form.thousands) == " ":
            text = text.replace("\u00a0", sign).replace("\u202f", sign)
        if sign and sign in text:
            whole, point, rest = text.partition(decimal)
            is_grouped = re.fullmatch(rf"[-+]?\d{{1,3}}({re.escape(sign)}\d{{3}})+", whole)
            text = whole.replace(sign, "") + point + rest if is_grouped else text
        if "d" in text.lower() and (match := _FORTRAN.fullmatch(text)):
            text = f"{match[1]}e{match[2]}"
        with suppress(ValueError):
            if not any(sign in text for sign in ("_" if decimal == "." else "_.")):
                return float(text if decimal == "." else text.replace(",", "."))
        column = "" if position is None else f"column {self.titles[position]!r}: "
        hint = ""
        if decimal == "." and _COMMA_INSIDE.fullmatch(text):
            hint = "; if commas are decimal signs, write 'format: {decimal: \",\"}'"
        elif decimal == "," and "." in text:
            hint = "; its point is not a decimal sign here, because 'decimal' is ','"
        elif re.fullmatch(r"[-+]?\d{1,3}([,.' \u00a0\u202f]\d{3})+([,.]\d+)?", text):
            hint = "; if it has thousands, write 'format: {thousands: …}'"
        elif text.lower() in MISSING_LIKE:
            hint = "; if it means a missing value, write 'format: {missing: …}'"
        raise ValueError(f"{column}{text[:40]!r} is not a number{hint}")


def runs(
    lines: Sequence[str], parse: Callable[[Sequence[str]], Parsed], first: int = 0
) -> Iterator[tuple[int, Parsed | ValueError]]:
    """Lines parsed together, as many at once as possible, and the error of each line that cannot be parsed.

    `first` is the position of the first line, which is returned with each result.
    """
    if not lines:
        return
    try:
        yield first, parse(lines)
    except ValueError as error:
        if len(lines) == 1:
            yield first, error
            return
        middle = len(lines) // 2
        yield from runs(lines[:middle], parse, first)
        yield from runs(lines[middle:], parse, first + middle)


def _delimiter_of(first_lines: Sequence[str], form: FormatConfig) -> str:
    """The delimiter in the first line; the decimal sign may be one where all numbers are quoted."""
    bare = [re.sub(r'"[^"]*"', "", line) for line in first_lines]
    is_quoted = any('"' in line for line in first_lines) and form.decimal in "".join(bare[-1:])
    signs = [sign for sign in "\t;,|" if sign != form.decimal or is_quoted]
    delimiter = next((sign for sign in signs if sign in "".join(bare[:1])), None)
    return delimiter or (" " if " " in "".join(first_lines[-1:]).strip() else "\t")


class Reading:
    """Rows that are read, one run after another."""

    def __init__(
        self, rows: RowReader, usual: int, positions: Sequence[int], dated: Iterable[int],
        stated: tuple[str, int | None] = ("", None),
    ) -> None:  # fmt: skip
        self._rows, self._usual, self._dated, (self._form, self._date) = rows, usual, [*dated], stated
        self._numeric = [position for position in positions if position not in self._dated]
        self.columns = {position: array("d") for position in positions}
        self.n_row = self.n_waiting = self._n_between = self._cut_line = 0
        self._widths: list[tuple[int, int]] = []
        self.broken: list[int] = []
        self.since: Instant | None = None
        """The first date."""

    def parse(self, lines: Sequence[str]) -> tuple[int, int, dict[int, Array]]:
        """Width and number of rows, and their columns."""
        width = self._rows.width(lines)
        if width < self._usual:
            return width, len(lines), dict.fromkeys(self.columns, np.full(len(lines), np.nan))
        columns = dict(zip(self._numeric, self._rows.numbers(lines, self._numeric), strict=True))
        for position, texts in zip(self._dated, self._rows.texts(lines, self._dated), strict=True):
            try:
                if self._date is not None:
                    (days,) = self._rows.texts(lines, [self._date])
                    texts = [f"{day.strip()} {text.strip()}" for day, text in zip(days, texts, strict=True)]
                columns[position] = self._seconds(texts)
            except ValueError as error:
                raise ValueError(f"column {self._rows.titles[position]!r}: {error}") from None
        return width, len(lines), columns

    def add(self, width: int, n_row: int, columns: Mapping[int, Array], line: int) -> None:
        """Take rows, the first of which stands in a line."""
        for position, values in columns.items():
            self.columns[position].frombytes(values.tobytes())
        if width < self._usual:
            self.broken += range(self.n_row, self.n_row + n_row)
            self._cut_line = self._cut_line or line
        self._n_between += self.n_waiting if self.n_row else 0
        self.n_waiting = 0
        self.n_row += n_row
        self._widths.append((width, n_row))

    def remarks(self, is_unended: bool) -> Iterator[Issue]:
        """What is irregular; incomplete last rows are left out."""
        n_all, n_title, ends, cut = self.n_row, len(self._rows.titles), self._widths[-2:], set(self.broken)
        if is_unended and len(ends) > 1 and ends[1][1] == 1 and ends[1][0] < ends[0][0]:
            self.n_row -= 1
        while self.n_row > 1 and self.n_row - 1 in cut:
            self.n_row -= 1
        self.broken = [row for row in self.broken if row < self.n_row]
        if self.n_row < n_all:
            yield Issue("the last line is incomplete and is ignored", kind="truncated")
        elif is_unended:
            yield Issue(UNENDED, kind="unended")
        if self._n_between:
            yield Issue(f"blank lines or comments between rows: {self._n_between}", kind="interrupted")
        n_short = sum(n for width, n in self._widths if width < n_title) - (n_all - self.n_row)
        if n_short:
            text = f"rows with fewer cells than there are column names: {n_short}"
            if self.broken:
                text += (
                    f"; {len(self.broken)} cut off and read as missing, the first in line {self._cut_line}"
                )
            yield Issue(text, kind="ragged")

    def _seconds(self, texts: Sequence[str]) -> Array:
        """Time since the first date [s]."""
        missing = self._rows.is_missing
        instants = [None if missing(text) else instant(text, form=self._form) for text in texts]
        self.since = self.since or next(filter(None, instants), None)
        return seconds_since(self.since, instants)
