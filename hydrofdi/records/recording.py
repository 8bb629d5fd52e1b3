"""The columns of a measured file, and its channels in SI before they are cut into records."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import INFERRED_SAMPLING, Array, Channel
from hydrofdi.records.columns import (
    Column,
    Titled,
    columns_of,
    factor_to_si,
    find_column,
    scaled,
    time_column,
    titles_of_time,
    unknown_header_unit,
)
from hydrofdi.records.description import MeasuredConfig, is_counts, known_unit
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import shown_quantity

MOST_BYTES = 2**31


class Table(Titled, ABC):
    """Columns of one file; `remarks` are findings."""

    remarks: tuple[Issue, ...] = ()

    @property
    def has_decimal_commas(self) -> bool:
        """Whether numbers seem to have decimal commas, contrary to the description."""
        return False

    @property
    def has_numbers(self) -> bool:
        """Whether there are numbers or dates below the titles."""
        return True

    def row_place(self, row: int) -> str:
        """A row, numbered from 0, for messages."""
        return f"sample {row + 1}"

    def find(self, column: str) -> int:
        """Position of a column; `DataError` unless there is exactly one."""
        return find_column(self.titles, column, self.place)

    def load(self, positions: Sequence[int]) -> None:
        """Prepare to return columns, if reading them together is faster."""

    @abstractmethod
    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,), NaN where missing; `DataError` if it is not numeric."""

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, shape (n_row,), and NaN; of dates, the time since the first one [s].

        With dates comes the first one since 1970, in UTC or in an unknown zone [s].
        """
        return self.numbers(position), math.nan

    def text(self, position: int) -> str:
        """The value of a constant column; `DataError` if it changes, or is not text."""
        raise DataError(f"{self.place}: column {self.titles[position]!r} is not text")


class RejectionError(Exception):
    """No record can be formed; it is listed with the reason, and the other records continue."""

    def __init__(self, kind: str, text: str) -> None:
        self.remark = Issue(text, kind=kind, is_unusable=True)
        super().__init__(text)


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Turn whatever a library raises on a broken file into `RejectionError`."""
    try:
        yield
    except (DataError, RejectionError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise RejectionError("damaged", f"cannot be read as {what}: {reason}") from None


_GAP = 1.751
"""Longest step between samples without a gap, in median steps: 7/4 even if it is rounded."""
_DIGITS = 9
_FEWER = 0.99
_MOST_SAMPLES = 2**28


def counts_samples(values: Array) -> bool:
    """Whether a column rises by one from sample to sample: a counter, if it has no unit."""
    return values.size > 1 and bool(np.all(np.diff(values) == 1.0))


def sampling_of_times(times: Array, config: MeasuredConfig, table: Table) -> tuple[float, list[Issue]]:
    """The sampling frequency of the instants of a table [Hz], and remarks on gaps and uneven steps."""
    steps = np.diff(times)
    if n_missing := np.count_nonzero(~np.isfinite(times)):
        text = f"{n_missing} sampling instants are missing; give 'sampling_frequency' in place of 'time'"
        raise RejectionError("time", text)
    if (bad := np.flatnonzero(steps <= 0.0)).size:
        relation = "the same as" if steps[bad[0]] == 0.0 else "before"
        text = f"{table.row_place(int(bad[0]) + 1)}: the time is {relation} that of the row above"
        raise RejectionError("time", text)
    typical = float(np.median(steps))
    step = typical if np.any(steps > _GAP * typical) else (times[-1] - times[0]) / (times.size - 1)
    frequency = float(f"{1.0 / step:.{_DIGITS}g}")
    if not 0.0 < frequency < np.inf:
        raise RejectionError("time", f"time goes from {times[0]:g} s to {times[-1]:g} s")
    return frequency, _unevenness(times, steps, typical, config)


def _unevenness(times: Array, steps: Array, typical: float, config: MeasuredConfig) -> list[Issue]:
    gaps = int(np.count_nonzero(steps > _GAP * typical))
    asked = "" if config.resample is None else f"; interpolated at {config.resample:g} Hz"
    if gaps:
        longest = float(steps.max())
        text = f"{counted(gaps, 'gap')} in time, the longest {longest:.3g} s{asked}"
        return [Issue(text, kind="gap", is_unusable=config.resample is None)]
    even = np.linspace(times[0], times[-1], times.size)
    even -= times
    deviation = float(max(even.max(), -even.min())) / typical
    if deviation <= config.limits.uneven + 1e-4:
        return []
    text = f"sampling is uneven: up to {deviation:.0%} of a step from even{asked}"
    return [Issue(text, kind="uneven")]


def _resampled(channels: dict[Channel, Array], times: Array, frequency: float) -> dict[Channel, Array]:
    """Channels interpolated linearly at even instants."""
    n_time = int(np.floor((times[-1] - times[0]) * frequency + 0.01)) + 1
    if n_time > _MOST_SAMPLES:
        raise RejectionError("long", f"would have {counted(n_time, 'sample')} at {frequency:g} Hz")
    instants = times[0] + np.arange(n_time) / frequency
    return {channel: np.interp(instants, times, samples) for channel, samples in channels.items()}


_FIRST_DATE = 1e9
"""Least instant of a clock that counts from 1970 [s]."""

_TOLERANCE = 0.01
"""Share by which a stated sampling frequency may differ from a column of time."""


@dataclass(frozen=True)
class Recording:
    """Channels of one file, or of a part of it: a record that is not yet in a batch, whose attributes it has.

    `values` are what group and label may use; `scaled_headers` the units that the file states for channels
    with a gain, `units` those of its numbers; `stroke` is the last minus the first position, or zero; `date`
    the instant of its first sample since 1970 [s].
    """

    channels: dict[Channel, Array]
    sampling_frequency: float
    start_time: float = 0.0
    relative: frozenset[Channel] = frozenset()
    normalized: frozenset[Channel] = frozenset()
    remarks: tuple[Issue, ...] = ()
    values: Mapping[str, str] = field(default_factory=dict)
    scaled_headers: Mapping[Channel, str] = field(default_factory=dict)
    units: Mapping[Channel, str] = field(default_factory=dict)
    record_id: str = ""
    source: str = ""
    group: str = ""
    label: str = ""
    stroke: float = 0.0
    date: float = math.nan

    def remarked(self, remarks: Iterable[Issue]) -> Recording:
        """The recording with more remarks."""
        return replace(self, remarks=(*self.remarks, *remarks))

    def unit(self, channel: Channel) -> str:
        """Unit of a channel: SI, or ``counts``."""
        return "counts" if channel in self.relative else channel.unit

    def shown(self, channel: Channel, value: float) -> str:
        """A value of a channel in the unit of the file."""
        stated = "" if channel in self.relative else self.units.get(channel, "")
        return shown_quantity(value, self.unit(channel), stated)

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return next(iter(self.channels.values())).size


def recording_of(table: Table, config: MeasuredConfig) -> Recording:
    """The columns of a table, read according to a description."""
    columns, channels, times, since = samples_of(table, config)
    doubts: list[Issue] = []
    for column in columns.values():
        doubts += unknown_header_unit(column.config, table.unit(column.position))
    if config.sampling_frequency is not None:
        doubts += _contradicting_times(table, config.sampling_frequency)
    values = {name: table.text(table.find(column)) for name, column in config.columns.items()}
    n_time = next(iter(channels.values())).size
    if n_time < 2:
        raise RejectionError("short", f"contains {counted(n_time, 'sample')}")
    frequency, start, wanted = config.sampling_frequency or 0.0, 0.0, config.resample
    if times is not None:
        frequency, uneven = sampling_of_times(times, config, table)
        start, doubts = float(times[0]), [*doubts, *uneven]
    elif config.sampling_frequency_is == "inferred":
        text = f"the sampling frequency of {frequency:g} Hz is inferred, not documented"
        doubts.append(Issue(text, kind=INFERRED_SAMPLING))
    if times is not None and wanted is not None:
        if wanted <= _FEWER * frequency:
            text = f"resampled from {frequency:g} Hz to {wanted:g} Hz without a filter"
            doubts.append(Issue(f"{text}: frequencies above {wanted / 2:g} Hz are aliased", kind="folded"))
        channels, frequency = _resampled(channels, times, wanted), wanted
    return Recording(
        channels,
        frequency,
        start,
        frozenset(channel for channel, column in columns.items() if is_counts(column.unit)),
        remarks=(*table.remarks, *doubts),
        values=values,
        scaled_headers={
            channel: table.unit(column.position)
            for channel, column in columns.items()
            if column.config.gain is not None
        },
        units={channel: column.unit for channel, column in columns.items()},
        date=start if start >= _FIRST_DATE else since + start,
    )


class Samples(NamedTuple):
    """Columns of a table; their samples in SI or in counts; instants [s], None without a column of time; and
    what these count from if they are dates [s since 1970], else NaN.
    """

    columns: Mapping[Channel, Column]
    channels: dict[Channel, Array]
    times: Array | None
    since: float


def samples_of(table: Table, config: MeasuredConfig) -> Samples:
    """The samples that a description finds in a table, also if few or uneven."""
    columns, since = columns_of(table, config.channels), math.nan
    time = None if config.time is None else time_column(table, config.time)
    times: Array | None = None
    table.load([column.position for column in (*columns.values(), time) if column is not None])
    if time is not None:
        times, since = table.instants(time.position)
        if not table.is_dated(time.position):
            has_unit = time.config.unit or table.unit(time.position)
            if not has_unit and counts_samples(times):
                raise DataError(
                    f"{table.place}: column {time.title!r} (time): counts the samples and is not a time; give"
                    " the sampling frequency instead, such as 'sampling_frequency: 1 kHz'"
                )
            times = time.in_si(times)
    channels = {key: each.in_si(table.numbers(each.position)) for key, each in columns.items()}
    lengths: dict[str, int] = {str(channel): samples.size for channel, samples in channels.items()}
    if times is not None:
        lengths["time"] = times.size
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RejectionError("wrong_length", f"columns have different numbers of samples: {found}")
    return Samples(columns, channels, times, since)


def _contradicting_times(table: Table, frequency: float) -> tuple[Issue, ...]:
    """A remark if median and mean step of a time column contradict the stated sampling frequency."""
    for position in (n for n in titles_of_time(table) if known_unit(table.unit(n))):
        title = table.titles[position]
        try:
            values = table.numbers(position)
        except DataError:
            continue
        times = scaled(values, factor_to_si(table.unit(position), "s", title))
        steps = np.diff(times[np.isfinite(times)])
        expected = np.array([np.median(steps), np.mean(steps)]) * frequency if steps.size else np.ones(2)
        if np.all(np.abs(expected - 1.0) > _TOLERANCE):
            with np.errstate(divide="ignore"):
                found = frequency / expected[0]
            text = f"column {title!r} says {found:g} Hz, the description {frequency:g} Hz"
            return (Issue(text, kind="sampling_differs"),)
    return ()
