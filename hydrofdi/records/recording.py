"""The columns of a measured file, its channels in SI, and the parts that are cut from them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError, Issue
from hydrofdi.records import INFERRED_SAMPLING, Array, Channel, RecordBatch
from hydrofdi.records.columns import FileColumns, ReadColumn, RejectionError, columns_of, unknown_header_unit
from hydrofdi.records.description import CyclesConfig, MeasuredConfig, SegmentConfig, TrimConfig, is_counts
from hydrofdi.records.times import (
    FIRST_DATE,
    LAST_DATE,
    contradicting_times,
    require_seconds,
    sampling_of_times,
    time_column,
)
from hydrofdi.settings.messages import counted, shown_quantity
from hydrofdi.settings.quantities import ABOVE, BELOW
from hydrofdi.units import gauge_unit

_FEWER = 0.99
_MOST_SAMPLES = 2**28


def _on_grid(channels: dict[Channel, Array], times: Array, frequency: float) -> dict[Channel, Array]:
    """The samples at their places on an even clock; NaN in gaps."""
    indices = np.rint((times - times[0]) * frequency).astype(np.intp)
    gridded = {channel: np.full(indices[-1] + 1, np.nan) for channel in channels}
    for channel, samples in channels.items():
        gridded[channel][indices] = samples
    return gridded


def _resampled(channels: dict[Channel, Array], times: Array, frequency: float) -> dict[Channel, Array]:
    """Channels interpolated linearly at even instants."""
    n_time = int(np.floor((times[-1] - times[0]) * frequency + 0.01)) + 1
    if n_time > _MOST_SAMPLES:
        raise RejectionError("long", f"would have {counted(n_time, 'sample')} at {frequency:g} Hz")
    instants = times[0] + np.arange(n_time) / frequency
    return {channel: np.interp(instants, times, samples) for channel, samples in channels.items()}


@dataclass(frozen=True)
class Record(RecordBatch):
    """A batch of one record: a file, or a part of it.

    `headers` are the units that the file states for channels with a gain.
    """

    headers: Mapping[Channel, str] = field(default_factory=dict)

    def remarked(self, remarks: Iterable[Issue]) -> Record:
        """The record with more remarks."""
        return replace(self, remarks=((*self.remarks[0], *remarks),))

    def shown(self, channel: Channel, value: float) -> str:
        """A value of a channel in the unit of the file."""
        stated = "" if channel in self.relative else "".join(self.units.get(channel, ()))
        return shown_quantity(value, self.unit(channel), stated)


def recording_of(table: FileColumns, config: MeasuredConfig) -> Record:
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
    cycles = config.cycles
    gained = {channel: column for channel, column in columns.items() if column.config.gain is not None}
    return Record(
        {channel: samples[np.newaxis] for channel, samples in channels.items()},
        frequency,
        ("",),
        start_time=start,
        drive_period=config.drive_period or (None if cycles is None else cycles.period),
        relative=frozenset(channel for channel, column in columns.items() if is_counts(column.unit)),
        remarks=((*table.remarks, *doubts),),
        units={channel: frozenset([gauge_unit(column.unit)]) for channel, column in columns.items()},
        dates=(start if FIRST_DATE <= start <= LAST_DATE else since + start,),
        headers={channel: table.unit(column.position) for channel, column in gained.items()},
    )


class Samples(NamedTuple):
    """Columns of a table; their samples in SI or in counts; instants [s], None without a column of time; and
    what these count from if they are dates [s since 1970], else NaN.
    """

    columns: Mapping[Channel, ReadColumn]
    channels: dict[Channel, Array]
    times: Array | None
    since: float


def samples_of(table: FileColumns, config: MeasuredConfig) -> Samples:
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
            if not (time.config.unit or table.unit(time.position)):
                require_seconds(times, f"{table.place}: column {time.title[:60]!r}")
            times = time.in_si(times)
    channels = {key: each.in_si(table.numbers(each.position)) for key, each in columns.items()}
    if clocks and time is not None and times is not None:
        times, channels = _joined(table, time, times, channels, clocks)
    lengths: dict[str, int] = {str(channel): samples.size for channel, samples in channels.items()}
    if times is not None:
        lengths["time"] = times.size
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RejectionError("wrong_length", f"columns have different numbers of samples: {shown}")
    return Samples(columns, channels, times, since)


def _own_times(table: FileColumns, columns: Mapping[Channel, ReadColumn], time: int) -> dict[Channel, int]:
    """Positions of own time columns of channels, if they have other ones than `time`."""
    clocks, own = table.clocks(time), {channel: column.config.time for channel, column in columns.items()}
    positions = {
        channel: clocks.get(column.position, time) if (name := own[channel]) is None else table.find(name)
        for channel, column in columns.items()
    }
    return {channel: position for channel, position in positions.items() if position != time}


def _joined(
    table: FileColumns,
    time: ReadColumn,
    times: Array,
    channels: Mapping[Channel, Array],
    clocks: Mapping[Channel, int],
) -> tuple[Array, dict[Channel, Array]]:
    """Channels at the instants of `time` that all cover, those with own times interpolated linearly."""
    since, joined = table.instants(time.position)[1] if table.is_dated(time.position) else 0.0, dict(channels)
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
        joined[channel] = np.interp(times, own[has_both], values[has_both], np.nan, np.nan)
        known &= ~np.isnan(joined[channel])
    if not known.any():
        raise RejectionError("time", "the times of the columns do not overlap")
    first, last = int(np.argmax(known)), known.size - int(np.argmax(known[::-1]))
    return times[first:last], {channel: values[first:last] for channel, values in joined.items()}


_BAND = 0.2
"""Width of the band around the middle as a share of the range: noise does not cause an edge."""
_LEAST_STEPS, _UNEVEN, _ALIKE = 3, 0.05, 0.8
"""Of a period: least distances between edges, their largest spread, and least correlation one period on."""
Direction = Literal["rising", "falling", "both"]
_WANTED = {"rising": (1,), "falling": (-1,), "both": (1, -1)}


def drive_edges(
    samples: Array, drive: tuple[float, float], direction: Direction, side: int = 0
) -> tuple[NDArray[np.intp], int]:
    """First sample beyond the band around the middle after each change of side, and the last side.

    A side is 1 above the band, −1 below it, 0 if unknown; `drive` is the lowest and highest value of the
    channel.
    """
    low, high = drive
    middle, half = (low + high) / 2.0, ABOVE * _BAND * (high - low) / 2.0
    sides = np.concatenate([[side], 1 * (samples > middle + half) - (samples < middle - half)])
    decided = np.flatnonzero(sides)
    if not decided.size:
        return decided, side
    # Samples inside the band are skipped, so noise at the middle makes no edge.
    changes = decided[1:][np.diff(sides[decided]) != 0]
    return changes[np.isin(sides[changes], _WANTED[direction])] - 1, int(sides[decided[-1]])


def found_period(batch: RecordBatch, row: int = 0) -> float | None:
    """Period of the drive of a record [s]: the one that is known, or that of u; None if it has none.

    The rising edges of u are even, and u repeats from one to the next. It is rounded to half a sample.
    """
    u = batch.channels.get(Channel.INPUT_VOLTAGE)
    if batch.drive_period is not None or u is None or not np.isfinite(samples := u[row]).all():
        return batch.drive_period
    steps = np.diff(drive_edges(samples, (float(samples.min()), float(samples.max())), "rising")[0])
    if steps.size < _LEAST_STEPS or np.ptp(steps) > max(2.0, _UNEVEN * steps.mean()):
        return None
    lag = round(float(steps.mean()))
    # Even edges alone could be chance; the whole signal must repeat.
    is_repeated = np.corrcoef(samples[:-lag], samples[lag:])[0, 1] > _ALIKE
    return round(2.0 * float(steps.mean())) / (2.0 * batch.sampling_frequency) if is_repeated else None


_MARGIN = 0.02
"""Share of the stroke at each end that does not belong to the motion."""
_NOISE = 6.0
"""A stroke is larger than this many times the noise of the position."""
_MOST_ENDS = 20


@dataclass(frozen=True)
class Stroke:
    """A motion over a distance, in the position's unit.

    `start` and `arrival` are the first samples beyond 2 % and at 98 % of the distance.
    """

    distance: float
    start: int
    arrival: int

    @property
    def direction(self) -> str:
        """``+`` or ``-``."""
        return "+" if self.distance > 0.0 else "-"


def find_stroke(position: Array) -> Stroke | None:
    """The stroke in a position; None if its distance is within the noise."""
    n_end = min(_MOST_ENDS, max(1, position.size // 50))
    first, last = float(np.median(position[:n_end])), float(np.median(position[-n_end:]))
    noise = float(np.median(np.abs(np.diff(position)))) if position.size > 1 else 0.0
    distance = last - first
    if not abs(distance) > ABOVE * _NOISE * noise or not np.isfinite(distance):
        return None
    progress, margin = (position - first) / distance, ABOVE * _MARGIN
    return Stroke(distance, int(np.argmax(progress > margin)), int(np.argmax(progress >= 1.0 - margin)))


def short_stroke(recording: Record, stroke: Stroke | None, shortest: float | None) -> tuple[Issue, ...]:
    """A remark if a stroke is too short."""
    distance = 0.0 if stroke is None else abs(stroke.distance)
    if shortest is None or distance >= BELOW * shortest:
        return ()
    unit = recording.unit(Channel.PISTON_POSITION)
    return (
        Issue(f"the stroke is {distance:.4g} {unit}, less than {shortest:.4g} {unit}", kind="short_stroke"),
    )


def trimmed(recording: Record, trim: TrimConfig) -> Record:
    """The recording without its trimmed ends."""
    frequency, n_time = recording.sampling_frequency, recording.n_time
    first, stop = _samples(trim.start, frequency), n_time - _samples(trim.end, frequency)
    if stop - first < 2:
        raise RejectionError("short", f"lasts {n_time / frequency:g} s; nothing is left after trimming")
    return recording if (first, stop) == (0, n_time) else recording.window(first, stop)


def cycles_of(recording: Record, cycles: CyclesConfig) -> Iterator[Record | RejectionError]:
    """The cycles of a file, each with its own time zero; a remark states the time outside of them."""
    spans = _spans(recording, cycles)
    if not spans:
        raise RejectionError("no_cycle", f"contains no complete cycle by {cycles.by}")
    left_out = _left_out(recording, spans)
    for number, (first, stop) in enumerate(spans):
        cycle = replace(recording.window(first, stop), start_time=0.0)
        cycle = cycle.remarked(left_out) if number == 0 else cycle
        try:
            yield of_length(cycle, cycles.length, "the cycle")
        except RejectionError as rejection:
            yield rejection


def segment_of(recording: Record, stroke: Stroke | None, segment: SegmentConfig) -> Record:
    """The requested part of a stroke."""
    if stroke is None:
        raise RejectionError("no_motion", "the piston does not move")
    frequency = recording.sampling_frequency
    first, stop = {
        "motion": (stroke.start, stroke.arrival),
        "impact": (stroke.arrival - _samples(segment.before, frequency), recording.n_time),
        "hold": (stroke.arrival + _samples(segment.settle, frequency), recording.n_time),
    }[segment.part]
    if first < 0 or stop - first < 2:
        raise RejectionError("short", f"contains no {segment.part} of the stroke")
    part = replace(recording.window(first, stop), start_time=0.0)
    return of_length(part, segment.length, f"the {segment.part}")


def of_length(recording: Record, length: float | None, what: str) -> Record:
    """The first part of a recording, of the requested length [s]."""
    frequency = recording.sampling_frequency
    n_time = recording.n_time if length is None else _samples(length, frequency)
    if not 2 <= n_time <= recording.n_time:
        lasts = recording.n_time / frequency
        raise RejectionError("short", f"{what} lasts {lasts:g} s; the description requires {length or 0:g} s")
    return recording if n_time == recording.n_time else recording.window(0, n_time)


def _samples(duration: float, frequency: float) -> int:
    return round(min(duration * frequency, 1e15))


def _spans(recording: Record, cycles: CyclesConfig) -> list[tuple[int, int]]:
    if cycles.by == "period":
        assert cycles.period is not None
        per_cycle = cycles.period * recording.sampling_frequency
        n_cycle = int((recording.n_time + 1e-6) / per_cycle) if per_cycle >= 2.0 else 0
        starts = [round(round(number * per_cycle, 6)) for number in range(n_cycle)]
        return [(start, start + int(per_cycle + 1e-6)) for start in starts]
    (samples,) = recording[cycles.channel]
    if not (known := samples[np.isfinite(samples)]).size:
        return []
    drive = float(known.min()), float(known.max())
    return list(pairwise(drive_edges(samples, drive, cycles.edge)[0].tolist()))


def _left_out(recording: Record, spans: list[tuple[int, int]]) -> tuple[Issue, ...]:
    before, after = spans[0][0], recording.n_time - spans[-1][1]
    if not before + after:
        return ()
    durations = [n / recording.sampling_frequency for n in (before, after)]
    text = f"{durations[0]:g} s before the first cycle and {durations[1]:g} s after the last are left out"
    return (Issue(text, kind="left_out"),)


_HOLD = 5
"""The last fifth is the hold."""


def normalized(record: Record, recording: Record, kind: str) -> Record:
    """A part of a recording with divided pressures, which are then relative."""
    units = {recording.unit(channel) for channel in recording.channels if channel.is_pressure}
    if len(units) > 1:
        raise DataError(
            f"normalize: pressures in {' and in '.join(sorted(units, reverse=True))}"
            " cannot be divided by one another"
        )
    if kind == "supply":
        pressure = float(recording[Channel.SUPPLY_PRESSURE][0].mean())
    else:
        last = recording.n_time - recording.n_time // _HOLD
        chambers = (Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE)
        pressure = max(float(recording[chamber][0, last:].mean()) for chamber in chambers)
    if not pressure > 0.0:
        raise RejectionError(
            "no_reference", f"the {kind} pressure is {pressure:g}; pressures cannot be divided by it"
        )
    divided = {name: samples / pressure for name, samples in record.channels.items() if name.is_pressure}
    shown = record.shown(Channel.CHAMBER_1_PRESSURE, pressure)
    remark = Issue(f"pressures are divided by the {kind} pressure, {shown}", kind="normalized")
    return replace(
        record.remarked([remark]),
        channels={**record.channels, **divided},
        relative=record.relative | divided.keys(),
        normalized=frozenset(divided),
    )
