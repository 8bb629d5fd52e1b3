"""The columns of a measured file, and its channels in SI before they are cut into records."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records import INFERRED_SAMPLING, Array, Channel
from hydrofdi.records.columns import ReadColumn, RejectionError, Table, columns_of, unknown_header_unit
from hydrofdi.records.description import MeasuredConfig, is_counts
from hydrofdi.records.times import (
    FIRST_DATE,
    LAST_DATE,
    contradicting_times,
    counts_samples,
    require_seconds,
    sampling_of_times,
    time_column,
)
from hydrofdi.settings.messages import counted, shown_quantity
from hydrofdi.units import gauge_unit

_FEWER = 0.99
_MOST_SAMPLES = 2**28


def _on_grid(channels: dict[Channel, Array], times: Array, frequency: float) -> dict[Channel, Array]:
    """The samples at their places on an even clock; NaN in gaps."""
    places = np.rint((times - times[0]) * frequency).astype(np.intp)
    found = {channel: np.full(places[-1] + 1, np.nan) for channel in channels}
    for channel, samples in channels.items():
        found[channel][places] = samples
    return found


def _resampled(channels: dict[Channel, Array], times: Array, frequency: float) -> dict[Channel, Array]:
    """Channels interpolated linearly at even instants."""
    n_time = int(np.floor((times[-1] - times[0]) * frequency + 0.01)) + 1
    if n_time > _MOST_SAMPLES:
        raise RejectionError("long", f"would have {counted(n_time, 'sample')} at {frequency:g} Hz")
    instants = times[0] + np.arange(n_time) / frequency
    return {channel: np.interp(instants, times, samples) for channel, samples in channels.items()}


@dataclass(frozen=True)
class Recording:
    """Channels of one file, or of a part of it: a record that is not yet in a batch, whose attributes it has.

    `scaled_headers` are the units that the file states for channels with a gain, `units` those of its
    numbers; `date` is the instant of its first sample since 1970 [s].
    """

    channels: dict[Channel, Array]
    sampling_frequency: float
    start_time: float = 0.0
    relative: frozenset[Channel] = frozenset()
    normalized: frozenset[Channel] = frozenset()
    remarks: tuple[Issue, ...] = ()
    scaled_headers: Mapping[Channel, str] = field(default_factory=dict)
    units: Mapping[Channel, str] = field(default_factory=dict)
    record_id: str = ""
    source: str = ""
    group: str = ""
    label: str = ""
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
        doubts += contradicting_times(table, config.sampling_frequency)
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
    elif times is not None and any(doubt.kind == "gap" for doubt in doubts):
        channels = _on_grid(channels, times, frequency)
    return Recording(
        channels,
        frequency,
        start,
        frozenset(channel for channel, column in columns.items() if is_counts(column.unit)),
        remarks=(*table.remarks, *doubts),
        scaled_headers={
            channel: table.unit(column.position)
            for channel, column in columns.items()
            if column.config.gain is not None
        },
        units={channel: gauge_unit(column.unit) for channel, column in columns.items()},
        date=start if FIRST_DATE <= start <= LAST_DATE else since + start,
    )


class Samples(NamedTuple):
    """Columns of a table; their samples in SI or in counts; instants [s], None without a column of time; and
    what these count from if they are dates [s since 1970], else NaN.
    """

    columns: Mapping[Channel, ReadColumn]
    channels: dict[Channel, Array]
    times: Array | None
    since: float


def samples_of(table: Table, config: MeasuredConfig) -> Samples:
    """The samples that a description finds in a table, also if few or uneven."""
    stated = config.time
    if stated is not None and (stated.format or stated.date):
        date = None if stated.date is None else table.find(stated.date)
        table.date_by(table.find(stated.column), stated.format, date)
    columns, since = columns_of(table, config.channels), math.nan
    time = None if stated is None else time_column(table, stated)
    clocks = {} if time is None else _own_times(table, columns, time.position)
    times: Array | None = None
    used = [column.position for column in (*columns.values(), time) if column is not None]
    table.load([*dict.fromkeys((*used, *clocks.values()))])
    if time is not None:
        times, since = table.instants(time.position)
        if not table.is_dated(time.position):
            has_unit = time.config.unit or table.unit(time.position)
            if not has_unit and counts_samples(times):
                raise DataError(
                    f"{table.place}: column {time.title!r} (time): counts the samples and is not a time; give"
                    " the sampling frequency instead, such as 'sampling_frequency: 1 kHz'"
                )
            if not has_unit:
                require_seconds(times, f"{table.place}: column {time.title[:60]!r}")
            times = time.in_si(times)
    channels = {key: each.in_si(table.numbers(each.position)) for key, each in columns.items()}
    if clocks and time is not None and times is not None:
        times, channels = _joined(table, time, times, channels, clocks)
    lengths: dict[str, int] = {str(channel): samples.size for channel, samples in channels.items()}
    if times is not None:
        lengths["time"] = times.size
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RejectionError("wrong_length", f"columns have different numbers of samples: {found}")
    return Samples(columns, channels, times, since)


def _own_times(table: Table, columns: Mapping[Channel, ReadColumn], time: int) -> dict[Channel, int]:
    """Positions of own time columns of channels, if they have other ones than `time`."""
    clocks, own = table.clocks(time), {channel: each.config.time for channel, each in columns.items()}
    found = {
        channel: clocks.get(each.position, time) if (name := own[channel]) is None else table.find(name)
        for channel, each in columns.items()
    }
    return {channel: position for channel, position in found.items() if position != time}


def _joined(
    table: Table,
    time: ReadColumn,
    times: Array,
    channels: Mapping[Channel, Array],
    clocks: Mapping[Channel, int],
) -> tuple[Array, dict[Channel, Array]]:
    """Channels at the instants of `time` that all cover, those with own times interpolated linearly."""
    since, found = table.instants(time.position)[1] if table.is_dated(time.position) else 0.0, dict(channels)
    known = np.isfinite(times)
    for channel, position in clocks.items():
        own, first = table.instants(position)
        own = (
            own + (first - since) if table.is_dated(position) else replace(time, position=position).in_si(own)
        )
        values = channels[channel]
        has_both = np.isfinite(own) & np.isfinite(values)
        if np.any(np.diff(own[has_both]) <= 0.0) or np.count_nonzero(has_both) < 2:
            raise RejectionError(
                "time", f"{channel}: its own time {table.titles[position]!r} does not increase"
            )
        found[channel] = np.interp(times, own[has_both], values[has_both], np.nan, np.nan)
        known &= ~np.isnan(found[channel])
    if not known.any():
        raise RejectionError("time", "the times of the columns do not overlap")
    first, last = int(np.argmax(known)), known.size - int(np.argmax(known[::-1]))
    return times[first:last], {channel: values[first:last] for channel, values in found.items()}
