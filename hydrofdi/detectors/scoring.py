"""Scores of healthy records over time, as the detector computes them; samples are not kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors import verdicts
from hydrofdi.detectors.configuration import DetectorConfig, feature_of
from hydrofdi.errors import ConfigError, DataError, Issue
from hydrofdi.indicators.faults import OF_LEAKS
from hydrofdi.indicators.measuring import spool_remedy
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk, EvenStream, TimeWindower, Window, Windower

_CHUNK = 2**17
"""Number of samples of a record that are cut at a time; overlapping windows multiply their memory."""

_MOST_SAMPLES = 2**21
"""Number of samples per channel that are measured at a time."""

_WRONG_SIZES = {"unusual", "low_pressure"}
"""Kinds of remarks on channels whose unit or gain is probably wrong."""


_NOT_EVEN = {"uneven", "gaps"}
"""Kinds of remarks on records whose samples are not even, or mostly missing."""


class _Record(NamedTuple):
    """Duration [s], group, label and name of a record; group and label are empty if unknown."""

    duration: float
    group: str
    label: str
    name: str


class HealthyScores:
    """Scores of healthy records, and statistics of their channels.

    Attributes
    ----------
    config, feature, channels : DetectorConfig, Feature, tuple of Channel
        What is measured, and the channels that it reads.
    records : list of _Record
        In the order in which they were read.
    record : list of int, length n_score
        Index of the record of each window.
    is_apart : list of bool
        Whether a window is used to set limits: only non-overlapping windows are.
    measured : list of Measured
        What is measured of each window; of windows that set no limits, the numbers alone.
    all_scores : ndarray, shape (n_score,)
        Set when all numbers are known.
    facts : dict of Channel to list of mapping of str to ndarray, shape (n_window,)
        As from `channel_facts`.
    """

    def __init__(self, config: DetectorConfig, first: RecordBatch, drive: tuple[float, float] | None) -> None:
        window, frequency = config.window, first.sampling_frequency
        if window.by == "cycle" and (window.duration is None or window.every is not None):
            length = "give the length of each cycle, counted from its edge, as 'window' alone"
            raise ConfigError(f"by=cycle: {length}")
        self.config, self.first, self.feature = config, first, feature_of(config)
        seen = self.feature.channels | (self.feature.optional_channels & first.channels.keys())
        seen |= {window.channel} if window.by == "cycle" else set()
        seen |= {verdicts.TEMPERATURE} & first.channels.keys()
        self.channels = tuple(channel for channel in Channel if channel in seen)
        duration = first.duration if window.duration is None else window.duration
        self.n_sample = round(duration * frequency)
        if self.n_sample < 2:
            raise ConfigError(f"window: {duration:g} s at {frequency:g} Hz are fewer than 2 samples")
        self.windower = window.windower(self.n_sample, self.channels, frequency, drive)
        self.records: list[_Record] = []
        self.record: list[int] = []
        self.is_apart: list[bool] = []
        self.measured: list[verdicts.Measured] = []
        self.all_scores: Array = np.empty(0)
        self.facts: dict[Channel, list[Mapping[str, Array]]] = {}

    def read(self, batches: Iterable[RecordBatch]) -> None:
        """Score the windows of records."""
        waiting = list[Window]()
        rows = ((batch, row) for batch in batches for row in range(batch.n_record))
        for records, row in rows:
            if not row:
                self._check(records)
            name = " ".join(dict.fromkeys((records.sources[row], records.record_ids[row]))).strip()
            label = records.labels[row] if records.labels else ""
            self.records.append(_Record(records.duration, records.groups[row], label, name))
            end = -np.inf
            for window in windows_along(records, row, self.windower):
                self.record.append(len(self.records) - 1)
                self.is_apart.append(bool(window.time[0] > end))
                end = float(window.time[-1]) if self.is_apart[-1] else end
                waiting.append(window)
                if len(waiting) * self.n_sample >= _MOST_SAMPLES:
                    self._measure(waiting)
                    waiting = []
        self._measure(waiting)

    def _measure(self, windows: Sequence[Window]) -> None:
        """Measure all windows that wait."""
        apart, nothing = self.is_apart[len(self.measured) :], np.full(len(self.feature.numbers), np.nan)
        sound, measured = [window for window in windows if window.fault is None], list[verdicts.Measured]()
        if sound:
            records = verdicts.records_of(sound, self.channels, self.windower.sampling_frequency)
            are_apart = [own for own, window in zip(apart, windows, strict=True) if window.fault is None]
            for channel in (
                each for each in self.channels if each is not verdicts.TEMPERATURE and any(are_apart)
            ):
                self.facts.setdefault(channel, []).append(verdicts.channel_facts(records[channel][are_apart]))
            measured = verdicts.measured_windows(records, self.feature)
        in_order = iter(measured)
        for window, is_apart in zip(windows, apart, strict=True):
            own = verdicts.Measured(nothing, window.fault) if window.fault else next(in_order)
            self.measured.append(own if is_apart else verdicts.Measured(own.numbers))

    @cached_property
    def faults(self) -> list[Issue]:
        """Why windows that would set limits have no score."""
        return [each.fault for each in self.measured if each.fault is not None]

    @cached_property
    def complete(self) -> list[verdicts.Measured]:
        """What is measured of the windows that set limits and have all numbers."""
        pairs = zip(self.measured, self.is_apart, strict=True)
        return [each for each, is_apart in pairs if is_apart and np.isfinite(each.numbers).all()]

    @property
    def n_impossible(self) -> Counter[str]:
        """Output → number of windows in which it is doubtful."""
        return Counter(doubt.where for each in self.complete for doubt in each.doubts)

    @cached_property
    def refused(self) -> list[Issue]:
        """Why no actuator gives a window, of each such window."""
        return [issue for each in self.complete for issue in self._refusals(each.doubts)[:1]]

    @property
    def conditions(self) -> dict[str, tuple[float, float]]:
        """Condition → its lowest and highest value."""
        values: dict[str, list[float]] = {}
        for each in self.complete:
            doubtful = {doubt.where for doubt in each.doubts}
            for name, value in each.conditions.items():
                if name not in doubtful and np.isfinite(value):
                    values.setdefault(name, []).append(value)
        return {name: (min(own), max(own)) for name, own in sorted(values.items())}

    def _refusals(self, doubts: Sequence[Issue]) -> list[Issue]:
        """Doubts by which no actuator gives a window. A leak or a load explains one of a misfit and an
        invisible compressibility; without position, the forces that replace it explain any misfit.
        """
        spared = {*OF_LEAKS} if len({each.kind for each in doubts}.intersection(OF_LEAKS)) < 2 else set()
        if Channel.PISTON_POSITION not in self.channels:
            spared = {*OF_LEAKS, "unexplained"}
        return [each for each in doubts if each.kind not in spared]

    def _check(self, batch: RecordBatch) -> None:
        """Check that a batch matches the first one."""
        first, channels, config = self.first, self.channels, self.config
        source, other = batch.sources[0], first.sources[0]
        if batch.sampling_frequency != first.sampling_frequency:
            raise DataError(
                f"{source}: is sampled at {batch.sampling_frequency:g} Hz, but {other} at"
                f" {first.sampling_frequency:g} Hz; a detector needs a single sampling frequency"
            )
        if missing := [channel for channel in channels if channel not in batch.channels]:
            pairs = (
                pair for pair in self.feature.indicators.items() if not pair[1].channels.isdisjoint(missing)
            )
            label, needs = next(pairs, (f"the detector after {other}", self.feature.indicator))
            remedy = spool_remedy(missing, needs)
            raise DataError(f"{source}: has no {' and no '.join(missing)}, which {label} needs{remedy}")
        if obstacle := verdicts.without_scale(batch, channels):
            raise DataError(f"{source}: {obstacle}")
        for remark in chain.from_iterable(batch.remarks):
            if remark.kind in _NOT_EVEN and remark.is_unusable:
                raise DataError(f"{source}: {remark.message}")
            if not config.accept and remark.kind in _WRONG_SIZES and remark.where in channels:
                raise DataError(f"{source}: {remark.message}; --accept trains anyway")
        needs_length = config.window.by == "time" and config.window.duration is None
        if needs_length and batch.n_time != first.n_time:
            raise DataError(
                f"{source}: lasts {batch.duration:g} s, but {other} {first.duration:g} s; give the duration"
                " of a window as 'window'"
            )

    @property
    def interval(self) -> float:
        """Mean time between scores [s]."""
        if isinstance(self.windower, TimeWindower):
            return self.windower.n_every / self.windower.sampling_frequency
        return sum(each.duration for each in self.records) / len(self.record)

    @property
    def duration(self) -> float:
        """Duration of a window [s]."""
        return self.n_sample / self.windower.sampling_frequency

    @cached_property
    def is_used(self) -> NDArray[np.bool_]:
        """Whether each score is used to set limits, shape (n_score,)."""
        return np.array(self.is_apart, dtype=bool) & ~np.isnan(self.all_scores)

    @cached_property
    def scores(self) -> Array:
        """The scores that are used to set limits."""
        return self.all_scores[self.is_used]

    @property
    def hours(self) -> float:
        """Time that has scores [h]."""
        n_score = int(np.isfinite(self.all_scores).sum())
        return n_score * self.interval / 3600.0 if n_score else 0.0

    @cached_property
    def groups(self) -> list[str]:
        """Group of each record; a record without a group is its own group."""
        return [each.group or f"record {index}" for index, each in enumerate(self.records)]

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Group index of each score that is used to set limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return numbers[np.array(self.record, dtype=np.intp)[self.is_used]]

    @property
    def has_groups(self) -> bool:
        """Whether groups were stated."""
        return any(each.group for each in self.records)


def windows_along(records: RecordBatch, row: int, windower: Windower) -> Iterator[Window]:
    """Windows of a record, a few at a time, as from a stream."""
    channels, time = tuple(windower.needs), records.time
    stream = EvenStream(records.sampling_frequency, channels)
    state, held = stream.start(), windower.start()
    for first in range(0, records.n_time, _CHUNK):
        part = slice(first, first + _CHUNK)
        chunk = Chunk(time[part], {channel: records[channel][row, part] for channel in channels})
        state, pieces, _ = stream.step(state, chunk)
        for piece in pieces:
            held, windows = windower.step(held, piece)
            yield from windows
