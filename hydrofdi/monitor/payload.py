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

    def read(self, payload: bytes) -> Chunk:
        """The samples of a payload: one JSON object, or one on each line."""
        return joined([self.chunk([sample]) for sample in self._objects(payload)])

    def read_all(self, payloads: Sequence[bytes]) -> Chunk:
        """The samples of payloads, at once if all have the same form; those that are not understood are a
        sample each that could not be read."""
        with suppress(PayloadError, UnicodeDecodeError):
            objects = [each for payload in payloads for each in self._objects(payload)]
            if len(set(map(_form, objects))) == 1:
                return self.chunk(objects)
        chunks = []
        for payload in payloads:
            try:
                chunks.append(self.read(payload))
            except (PayloadError, UnicodeDecodeError) as error:
                chunks.append(malformed("message", payload[:60].decode(errors="replace"), str(error)))
        return joined(chunks)

    def _objects(self, payload: bytes) -> list[dict[str, Any]]:
        if len(payload) > self.config.limits.payload:
            raise PayloadError(f"is larger than {counted(self.config.limits.payload, 'byte')}")
        lines = [line for line in payload.splitlines() if line.strip()]
        are_objects = len(lines) > 1 and lines[0].rstrip().endswith(b"}")
        return [parsed(line) for line in (lines if are_objects else [payload])]

    def chunks(self, lines: Sequence[str]) -> list[Chunk]:
        """Samples of complete lines."""
        return super().chunks([line for line in lines if line.strip()])

    def block(self, lines: Sequence[str]) -> Chunk:
        """A line, or lines with the same keys and one sample each, as one block."""
        objects = [parsed(line) for line in lines]
        if len({tuple(sample) for sample in objects}) > 1:
            raise PayloadError("lines have different keys")
        if len(objects) == 1:
            return self.chunk(objects)
        return self.chunk([{key: [sample[key] for sample in objects] for key in objects[0]}])

    def chunk(self, objects: Sequence[Mapping[str, Any]]) -> Chunk:
        """The samples of JSON objects of the same form."""
        first = objects[0]
        time, channels = self._columns_of({key: value for key, value in first.items() if key != _FREQUENCY})
        values = {
            channel: [_listed(sample[column.title]) for sample in objects]
            for channel, column in channels.items()
        }
        lengths = {tuple(map(len, lists)) for lists in values.values()}
        if len(lengths) > 1:
            raise PayloadError("the channels have different numbers of samples")
        (counts,) = lengths
        in_si = {
            channel: column.in_si(_numbers(column.title, [*chain.from_iterable(values[channel])]))
            for channel, column in channels.items()
        }
        if time is not None:
            instants = [self._instants(time, *each) for each in zip(objects, counts, strict=True)]
            times = instants[0] if len(instants) == 1 else np.concatenate(instants)
        elif self.clock is not None:
            times = self.clock.take(sum(counts))
        else:
            raise PayloadError("has no time stamp; add 'time' [s]")
        return Chunk(times, in_si)

    def _instants(self, time: ReadColumn, sample: Mapping[str, Any], n_time: int) -> Array:
        """Instants of the samples of an object [s], shape (n_time,)."""
        times = self._times(time, sample[time.title])
        if times.size == 1 and _FREQUENCY in sample:
            with np.errstate(over="ignore"):
                times = times + np.arange(n_time) / _frequency(sample[_FREQUENCY])
        if times.size != n_time:
            stamps = counted(times.size, "time stamp")
            raise PayloadError(f"has {stamps} for {counted(n_time, 'sample')}, and no '{_FREQUENCY}'")
        return times

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

    def _times(self, column: ReadColumn, value: Any) -> Array:
        """Instants [s] from numbers or dates, shape (n_time,)."""
        if not _is_text(value):
            return column.in_si(_numbers(column.title, _listed(value)))
        texts = value if isinstance(value, list) else [value]
        try:
            return unix_seconds(texts, self.config.time_zone)
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


def _form(sample: Mapping[str, Any]) -> tuple[tuple[str, ...], tuple[bool, ...]]:
    """Keys, and which of them have texts."""
    return tuple(sample), tuple(map(_is_text, sample.values()))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


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
