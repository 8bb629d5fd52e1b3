"""Bytes of text in any pieces → samples."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import groupby
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.payload import Lines, PayloadReader, SampleClock, stream_columns
from hydrofdi.monitor.sources import Position, joined
from hydrofdi.records import Channel
from hydrofdi.records.columns import ReadColumn
from hydrofdi.records.rows import HEAD_HINT, RowReader, require_text, wrong_encoding
from hydrofdi.records.streams import Chunk
from hydrofdi.records.times import is_dated, unix_seconds
from hydrofdi.settings.messages import counted


class CsvLines(Lines):
    """Reads a header, a row of units if there is one, and rows.

    A line that is not a row is a comment, a repeated header, or malformed.
    """

    def __init__(
        self, config: MonitorConfig, clock: SampleClock | None, needed: Collection[Channel], name: str
    ) -> None:
        super().__init__(config, clock, needed, name)
        self._rows = RowReader(config.format, [], name)
        self._channels: dict[Channel, ReadColumn] = {}
        self._time: ReadColumn | None = None
        self._has_begun = self._has_names = False

    def block(self, lines: Sequence[str]) -> Chunk:
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
            assert self.clock is not None
            in_si.append(self.clock.take(len(lines)))
        elif are_dates:
            in_si.append(unix_seconds(self._rows.texts(lines, [time.position])[0], self.config.time_zone))
        return Chunk(in_si.pop(), dict(zip(self._channels, in_si, strict=True)))

    def line(self, line: str, error: ValueError) -> list[Chunk]:
        """Read a line that is not a row, or the first after a header."""
        text = line.strip("\r ")
        if "\ufffd" in text and not self._has_begun:
            raise wrong_encoding(self.name, self.config.format.encoding)
        if self._rows.is_empty(text):
            return []
        try:
            if not self._rows.titles or (self._channels and self._is_header(text)):
                self._begin(text)
                if self._has_names:
                    return []
            if not self._channels:
                return self._first_after_header(text)
        except ValueError as failure:
            if not self._has_begun:
                is_worded = isinstance(failure, DataError)
                message = str(failure) if is_worded else f"{self.name}: {text[:60]!r} {failure}"
                raise DataError(message + HEAD_HINT) from None
            self._rows.titles, self.header, self._channels, error = [], [], {}, failure
        return super().line(text, error)

    def _begin(self, text: str) -> None:
        """Take a line as the header."""
        self._rows, self._channels, self.header = RowReader(self.config.format, [text], self.name), {}, [text]
        titles = self._rows.header(text)
        self._has_names = self._rows.has_names(titles)
        if not self._has_names and self.config.format.header is None:
            raise DataError(
                f"{self.name}: begins with {text[:60]!r}, which is not a header; write the names"
                " and units of the columns first, such as 'time [s],P1 [bar]', or 'format: {header: false}'"
            )
        self._rows.titles = titles if self._has_names else [str(n + 1) for n in range(len(titles))]

    def _first_after_header(self, text: str) -> list[Chunk]:
        titles, cells = self._rows.titles, self._rows.cells([text])[0]
        if self._has_names and not self._rows.units and self._rows.are_units(cells):
            self._rows.units = cells
            self.header.append(text)
            return []
        self._rows.dated = [
            n for n in range(len(titles)) if n >= len(cells) or not self._rows.is_number(cells[n])
        ]
        self._time, self._channels = stream_columns(
            self._rows, self.config, self.needed, has_clock=self.clock is not None
        )
        if self._time is None and self.clock is None:
            self._channels = {}
            raise DataError(
                f"{self.name}: has no column of time such as 'time [s]'; add it, or give the sampling"
                " frequency"
            )
        self._has_begun = True
        return self.chunks([text])

    def _is_header(self, text: str) -> bool:
        """Whether a line names columns, some of them known from the header before."""
        try:
            titles = self._rows.header(text)
        except ValueError:
            return False
        is_numeric = any(map(self._rows.is_number, filter(None, titles)))
        return not is_numeric and bool(set(titles) & set(self._rows.titles))


class TextLines:
    """Reads CSV with a header, or JSON lines: the first character decides."""

    def __init__(
        self, config: MonitorConfig, name: str, position: Position, needed: Collection[Channel] = ()
    ) -> None:
        self._name, self._largest = name, config.limits.payload
        n_sample, frequency = int(position.get("n_sample", 0)), config.sampling_frequency
        self._clock = None if frequency is None else SampleClock(frequency, n_sample)
        encoding = config.format.encoding
        self._encoding = "utf-8-sig" if encoding.lower() in ("utf-8", "utf8") else encoding
        self._csv, self._json = (
            kind(config, self._clock, needed, name) for kind in (CsvLines, PayloadReader)
        )
        self._lines: Lines | None = None
        self._rest, self._is_skipping = b"", "is_skipping" in position
        self._n_preamble = config.format.skip
        self._n_skip = int(position.get("n_skip", 0 if "header" in position else self._n_preamble))
        if header := position.get("header"):
            self._lines = self._csv
            self._lines.chunks(list(header))
            if self._clock is not None:
                self._clock.n_sample = n_sample

    @property
    def n_unfinished(self) -> int:
        """Number of bytes of the unfinished last line."""
        return len(self._rest)

    @property
    def position(self) -> dict[str, Any]:
        """Header and sample count, which are needed to continue with the unfinished line."""
        known: dict[str, Any] = {}
        if self._lines is not None and self._lines.header:
            known["header"] = list(self._lines.header)
        if self._clock is not None:
            known["n_sample"] = self._clock.n_sample
        if self._is_skipping:
            known["is_skipping"] = True
        if self._n_preamble:
            known["n_skip"] = self._n_skip
        return known

    def begin_anew(self) -> None:
        """What follows is the beginning of a file; an unfinished line is discarded."""
        self._rest, self._is_skipping, self._n_skip = b"", False, self._n_preamble

    def read(self, data: bytes, *, is_end: bool = False) -> Chunk | None:
        """Samples of the lines that are now complete; None without one."""
        self._require_text(data)
        text = self._rest + data
        half = b"\r" if text.endswith(b"\r") and not is_end else b""  # a line end may come in two pieces
        text = text.removesuffix(half)
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        whole, end, rest = text.rpartition(b"\n")
        if is_end:
            whole, end, rest = whole + end + rest, b"", b""
        self._rest = rest + half
        lines = whole.decode(self._encoding, errors="replace").split("\n") if whole or end else []
        if self._is_skipping and lines:
            lines, self._is_skipping = lines[1:], False
        if self._n_skip and lines:
            is_first = self._n_skip == self._n_preamble
            if is_first and self._lines is not None and self._lines.is_row(lines[0]):
                self._n_skip = 0  # a further file, which has no preamble
            if "\ufffd" in "".join(lines[: self._n_skip]):
                raise wrong_encoding(self._name, self._encoding)
            lines, self._n_skip = lines[self._n_skip :], max(0, self._n_skip - len(lines))
        if len(rest) > self._largest:
            if not self._is_skipping:  # one line is one loss, however long it is
                lines.append(rest.decode(self._encoding, errors="replace"))
            self._rest, self._is_skipping = b"", True
        chunks: list[Chunk] = []
        if self._fits(max(lines, key=len, default="")):
            chunks = self._chunks(lines)
        else:
            for fits, some in groupby(lines, self._fits):
                own, reason = list(some), f"is longer than {counted(self._largest, 'byte')}"
                chunks += self._chunks(own) if fits else [self._csv.lost(line, reason) for line in own]
        return joined(chunks) if chunks else None

    def _require_text(self, data: bytes) -> None:
        """Refuse UTF-16 and binary data before the first line."""
        if self._lines is not None:
            return
        require_text(self._name, data)
        if b"\0" in data.partition(b"\n")[0]:
            raise DataError(f"{self._name}: is not text in UTF-8; is it a binary file, or in UTF-16?")

    def _fits(self, line: str) -> bool:
        """Whether a line is short enough."""
        return len(line) * 4 <= self._largest or len(line.encode()) <= self._largest

    def _chunks(self, lines: list[str]) -> list[Chunk]:
        if self._lines is None:
            first = next((line.strip() for line in lines if line.strip()), "")
            if not first:
                return []
            self._lines = self._json if first.startswith("{") else self._csv
        return self._lines.chunks(lines)
