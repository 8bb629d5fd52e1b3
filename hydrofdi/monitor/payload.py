"""Samples from JSON: one sample, or a block of samples, per object."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources import joined, malformed
from hydrofdi.records import Array, Channel
from hydrofdi.records.columns import ReadColumn, Titled, columns_of, split_title
from hydrofdi.records.description import is_counts
from hydrofdi.records.rows import runs
from hydrofdi.records.streams import Chunk
from hydrofdi.records.times import time_column, unix_seconds
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import SI


class SampleClock:
    """Counts samples at a sampling frequency."""

    def __init__(self, sampling_frequency: float, n_sample: int = 0) -> None:
        self.sampling_frequency, self.n_sample = sampling_frequency, n_sample

    def take(self, n_time: int) -> Array:
        """Instants of the next samples [s], shape (n_time,)."""
        first, self.n_sample = self.n_sample, self.n_sample + n_time
        return np.arange(first, self.n_sample) / self.sampling_frequency


_FREQUENCY, _HERTZ = "sampling_frequency", SI("Hz", above=0.0)
_MOST_KEYS = 256


class PayloadError(ValueError):
    """A payload that is not understood; a short sentence says why. It is counted and skipped."""


class Lines:
    """Reads complete lines: as many at once as possible, and those that are not understood one by one.

    `header` has the lines that are needed to continue within the stream.
    """

    def __init__(
        self,
        config: MonitorConfig,
        clock: SampleClock | None = None,
        needed: Collection[Channel] = (),
        name: str = "JSON",
    ) -> None:
        self.header: list[str] = []
        self.config, self.clock, self.name, self.needed = config, clock, name, needed

    def chunks(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines."""
        chunks: list[Chunk] = []
        for row, chunk in runs(lines, self.block):
            chunks += self.line(lines[row], chunk) if isinstance(chunk, ValueError) else [chunk]
        return chunks

    def block(self, lines: Sequence[str]) -> Chunk:
        """Samples of lines of the same form."""
        raise NotImplementedError

    def is_row(self, line: str) -> bool:
        """Whether a line is a sample, or the header once more; it takes none."""
        n_sample = 0 if self.clock is None else self.clock.n_sample
        try:
            return line in self.header or self.block([line]).n_time > 0
        except ValueError:
            return False
        finally:
            if self.clock is not None:
                self.clock.n_sample = n_sample

    def line(self, line: str, error: ValueError) -> list[Chunk]:
        """A line that is something else: a sample that could not be read."""
        return [self.lost(line, str(error))]

    def lost(self, line: str, reason: str) -> Chunk:
        """A sample that could not be read; those that follow keep their instants."""
        if self.clock is not None:
            self.clock.n_sample += 1
        return malformed("line", line.strip("\r "), reason)


Columns = tuple[ReadColumn | None, dict[Channel, ReadColumn]]
"""Those of time and of channels."""


class PayloadReader(Lines):
    """JSON → samples in SI."""

    def __init__(self, *args: Any, **more: Any) -> None:
        super().__init__(*args, **more)
        self._known: dict[tuple[tuple[str, ...], tuple[int, ...]], Columns] = {}

    def read_all(self, payloads: Sequence[bytes]) -> Chunk:
        """The samples of payloads: one JSON object in each, or one on each line."""
        return joined(super().chunks([line for payload in payloads for line in self._lines_of(payload)]))

    def _lines_of(self, payload: bytes) -> list[str]:
        lines = [line for line in payload.splitlines() if line.strip()]
        is_whole = len(lines) < 2 or not lines[0].rstrip().endswith(b"}")
        is_whole = is_whole or len(payload) > self.config.limits.payload
        return [each.decode("utf-8-sig", errors="replace") for each in ([payload] if is_whole else lines)]

    def chunks(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines."""
        return super().chunks([line for line in lines if line.strip()])

    def block(self, lines: Sequence[str]) -> Chunk:
        """The samples of lines with JSON objects of the same keys."""
        if max(map(len, lines)) > self.config.limits.payload:
            raise PayloadError(f"is larger than {counted(self.config.limits.payload, 'byte')}")
        objects = [parsed(line) for line in lines]
        first = objects[0]
        if len(set(map(tuple, objects))) > 1:
            raise PayloadError("lines have different keys")
        time, channels = self._columns_of({key: value for key, value in first.items() if key != _FREQUENCY})
        in_si, lengths = dict[Channel, Array](), set[tuple[int, ...]]()
        for channel, column in channels.items():
            values, counts = _flat([sample[column.title] for sample in objects])
            in_si[channel] = column.in_si(_numbers(column.title, values))
            lengths.add(counts)
        if len(lengths) > 1:
            raise PayloadError("the channels have different numbers of samples")
        if time is not None:
            times = self._instants(time, objects, counts)
        elif self.clock is not None:
            times = self.clock.take(sum(counts))
        else:
            raise PayloadError("has no time stamp; add 'time' [s]")
        return Chunk(times, in_si)

    def _instants(
        self, time: ReadColumn, objects: Sequence[Mapping[str, Any]], counts: Sequence[int]
    ) -> Array:
        """Instants [s] of the samples of objects, which state all of them, or the first one and the rate."""
        stamps, n_stamps = _flat([sample[time.title] for sample in objects])
        times = self._times(time, stamps)
        if n_stamps == counts:
            return times
        if {*n_stamps} != {1} or _FREQUENCY not in objects[0]:
            stated = counted(n_stamps[0], "time stamp")
            raise PayloadError(f"has {stated} for {counted(counts[0], 'sample')}, and no '{_FREQUENCY}'")
        rates = [_frequency(sample[_FREQUENCY]) for sample in objects]
        with np.errstate(over="ignore"):
            each = [first + np.arange(n) / rate for first, n, rate in zip(times, counts, rates, strict=True)]
        return np.concatenate(each)

    def _columns_of(self, sample: Mapping[str, Any]) -> Columns:
        """The columns that keys mean; those of the last objects are cached."""
        keys = tuple(sample)
        dated = tuple(index for index, value in enumerate(sample.values()) if _is_text(value))
        if known := self._known.get((keys, dated)):
            return known
        if len(keys) > _MOST_KEYS:
            raise PayloadError(f"has {len(keys)} keys; at most {_MOST_KEYS}")
        names, configured = {*keys, *(split_title(key)[0] for key in keys)}, self.config.channels
        present = {channel: config for channel, config in configured.items() if config.column in names}
        if configured and not present:
            wanted = ", ".join(config.column for config in configured.values())
            raise PayloadError(f"has none of the keys {wanted[:100]}")
        header = Titled("JSON", keys, dated)
        config = self.config.model_copy(update={"channels": present})
        try:
            columns = stream_columns(header, config, self.needed, has_clock=self.clock is not None)
        except DataError as error:
            raise PayloadError(str(error).removeprefix("JSON: ")) from None
        if len(self._known) == _MOST_KEYS:
            self._known.clear()
        self._known[keys, dated] = columns
        return columns

    def _times(self, column: ReadColumn, values: list[Any]) -> Array:
        """Instants [s] from numbers or dates, shape (n_time,)."""
        if not _is_text(values):
            return column.in_si(_numbers(column.title, values))
        try:
            return unix_seconds(values, self.config.time_zone)
        except (AttributeError, TypeError, ValueError, OverflowError) as error:
            raise PayloadError(f"{column.title[:60]!r}: {str(error)[:200]}") from None


def stream_columns(
    header: Titled, config: MonitorConfig, needed: Collection[Channel], *, has_clock: bool
) -> tuple[ReadColumn | None, dict[Channel, ReadColumn]]:
    """The column of time of a stream, and those of its channels; a clock is preferred to dates."""
    channels = columns_of(header, config.channels, needed)
    for channel, column in channels.items():
        if is_counts(column.unit) and not column.config.unit:
            raise DataError(
                f"{header.place}: {column.title[:60]!r} is in counts; write 'gain' and 'unit' of {channel}"
            )
    if has_clock and config.time is None:
        header.dated = ()
    return time_column(header, config.time), channels


def parsed(text: bytes | str) -> dict[str, Any]:
    """A JSON object."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        raise PayloadError("is not JSON") from None
    if not isinstance(value, dict):
        raise PayloadError("is not a JSON object")
    return value


def _flat(values: list[Any]) -> tuple[list[Any], tuple[int, ...]]:
    """Values of objects, some of which may be lists, one after the other, and how many each has."""
    if list not in set(map(type, values)):
        return values, (1,) * len(values)
    lists = [value if isinstance(value, list) else [value] for value in values]
    return [*chain.from_iterable(lists)], tuple(map(len, lists))


def _numbers(key: str, values: list[Any]) -> Array:
    """Numbers, shape (n_time,); NaN for null."""
    if not set(map(type, values)) <= {float, int, type(None)}:
        raise PayloadError(f"{key[:60]!r}: is not a number")
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError:
        raise PayloadError(f"{key[:60]!r}: a number is too large") from None


def _is_text(value: Any) -> bool:
    return isinstance(value[0] if isinstance(value, list) and value else value, str)


def _frequency(value: Any) -> float:
    with suppress(ValueError, OverflowError):
        if math.isfinite(frequency := _HERTZ.parse(value)):
            return frequency
    raise PayloadError("'sampling_frequency' must be a number above zero [Hz]")
