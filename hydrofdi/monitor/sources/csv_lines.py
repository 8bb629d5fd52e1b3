"""Lines of delimited text as samples."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.contract import malformed
from hydrofdi.monitor.sources.payload import SampleClock, stream_columns
from hydrofdi.records.channels import Channel
from hydrofdi.records.dates import is_dated, unix_seconds
from hydrofdi.records.measured.columns import Column, is_unit, split_title
from hydrofdi.records.measured.rows import RowReader, runs
from hydrofdi.records.streams import Chunk


class CsvLines:
    """Reads a header, an optional row of units, and rows.

    A line that is not a row is a comment, a repeated header, or malformed.

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
        self._config, self._clock, self._name, self._needed = config, clock, name, needed
        self._rows = RowReader(config.format, [])
        self._units: list[str] | None = None
        self._channels: dict[Channel, Column] = {}
        self._time: Column | None = None
        self._zone, self._has_begun = config.time_zone, False

    def read(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines.

        Raises
        ------
        DataError
            The first line is not a usable header.
        """
        chunks: list[Chunk] = []
        for place, found in runs(lines, self._block):
            chunks += self._line(lines[place], found) if isinstance(found, ValueError) else [found]
        return chunks

    def _block(self, lines: Sequence[str]) -> Chunk:
        """Samples of rows."""
        if not self._channels:
            raise ValueError
        width, n_title = self._rows.width(lines), len(self._rows.titles)
        if width < n_title:
            raise ValueError(f"has {width} cells under {n_title} column names")
        columns = [*self._channels.values()]
        time, are_dates = self._time, False
        if time is not None:
            are_dates = is_dated(self._rows.texts(lines[:1], [time.position])[0][0])
            columns += [] if are_dates else [time]
        values = self._rows.numbers(lines, [column.position for column in columns])
        in_si = [column.in_si(numbers) for column, numbers in zip(columns, values, strict=True)]
        if time is None:
            assert self._clock is not None
            in_si.append(self._clock.take(len(lines)))
        elif are_dates:
            in_si.append(unix_seconds(self._rows.texts(lines, [time.position])[0], self._zone))
        return Chunk(in_si.pop(), dict(zip(self._channels, in_si, strict=True)))

    def _line(self, line: str, error: ValueError) -> list[Chunk]:
        """Read a line that is not a row, or the first after a header."""
        text = line.strip("\r ")
        if self._rows.is_empty(text):
            return []
        try:
            if not self._rows.titles:
                self._begin(text)
                return []
            if not self._channels:
                return self._first_after_header(text)
            if self._is_header(text):
                self._begin(text)
                return []
        except ValueError as failure:
            if not self._has_begun:
                is_worded = isinstance(failure, DataError)
                raise DataError(
                    str(failure) if is_worded else f"{self._name}: {text[:60]!r} {failure}"
                ) from None
            self._rows.titles, self.header, self._channels, error = [], [], {}, failure
        if self._clock is not None:
            self._clock.skip(1)
        return [malformed("line", text, str(error))]

    def _begin(self, text: str) -> None:
        """Take a line as the header."""
        self._rows = RowReader(self._config.format, [text])
        titles = self._rows.header(text)
        if any(self._rows.is_number(title) for title in titles if title):
            raise DataError(
                f"{self._name}: begins with {text[:60]!r}, which is not a header; write the names"
                " and units of the columns first, such as 'time [s],P1 [bar]'"
            )
        self._rows.titles, self._units, self.header, self._channels = titles, None, [text], {}

    def _first_after_header(self, text: str) -> list[Chunk]:
        titles, cells = self._rows.titles, self._rows.cells([text])[0]
        found = [cell.strip(" []()\r") for cell in cells]
        stated = [cell for cell in found if cell]
        is_row_of_units = stated and all(is_unit(cell) and not self._rows.is_number(cell) for cell in stated)
        if is_row_of_units and self._units is None:
            self._units = (found + [""] * len(titles))[: len(titles)]
            self.header.append(text)
            return []
        above = self._units or [""] * len(titles)
        units = [unit or split_title(title)[1] for unit, title in zip(above, titles, strict=True)]
        dated = [n for n in range(len(titles)) if n >= len(cells) or not self._rows.is_number(cells[n])]
        self._time, self._channels = stream_columns(
            titles, units, self._name, self._config, self._needed, dated, has_clock=self._clock is not None
        )
        if self._time is None and self._clock is None:
            self._channels = {}
            raise DataError(
                f"{self._name}: has no column of time such as 'time [s]'; add it, or give the sampling"
                " frequency"
            )
        self._has_begun = True
        return self.read([text])

    def _is_header(self, text: str) -> bool:
        """Whether a line names columns, some of them known from the header before."""
        try:
            titles = self._rows.header(text)
        except ValueError:
            return False
        is_numeric = any(map(self._rows.is_number, filter(None, titles)))
        return not is_numeric and bool(set(titles) & set(self._rows.titles))
