"""Rows of a text as numbers, run by run, with what is irregular."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.dates import Instant, instant, seconds_since
from hydrofdi.records.rows import UNENDED, RowReader


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
        found = dict(zip(self._numeric, self._rows.numbers(lines, self._numeric), strict=True))
        for position, texts in zip(self._dated, self._rows.texts(lines, self._dated), strict=True):
            try:
                if self._date is not None:
                    (days,) = self._rows.texts(lines, [self._date])
                    texts = [f"{day.strip()} {text.strip()}" for day, text in zip(days, texts, strict=True)]
                found[position] = self._seconds(texts)
            except ValueError as error:
                raise ValueError(f"column {self._rows.titles[position]!r}: {error}") from None
        return width, len(lines), found

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
