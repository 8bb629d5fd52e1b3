"""Scores of healthy records over time, as the detector computes them; samples are not kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.configuration import DetectorConfig, feature_of
from hydrofdi.detectors.trained.verdicts import (
    TEMPERATURE,
    Measured,
    channel_facts,
    measured_windows,
    records_of,
    widened,
    without_scale,
)
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


class HealthyScores:
    """Scores of healthy records, and statistics of their channels.

    Attributes
    ----------
    config, feature, channels : DetectorConfig, Feature, tuple of Channel
        What is measured, and the channels that it reads.
    durations, own_groups, labels, names : list
        Duration [s], group, label and name of each record; group and label are empty if unknown.
    record : list of int, length n_score
        Index of the record of each window.
    numbers : list of ndarray, shape (n_number,)
        What is measured of it; NaN if there is none.
    is_apart : list of bool
        Whether it is used to set limits: only non-overlapping windows are.
    all_scores : ndarray, shape (n_score,)
        Set when all numbers are known.
    facts : dict of Channel to list of mapping of str to ndarray, shape (n_window,)
        As from `channel_facts`.
    not_judged, reasons : Counter of str
        Kind of fault and message → number of windows that have no score.
    n_impossible, n_not_positive : Counter of str
        Output → number of windows in which it is doubtful, or not positive.
    refused : list of Issue
        Why no actuator gives a window, of each such window.
    fits : dict of str to float
        Output that states how well the model explains a window → largest value.
    conditions : dict of str to (float, float)
        Condition → its lowest and highest value.
    clearances : list of float
        As of `Measured`, of the windows that set limits.
    """

    def __init__(self, config: DetectorConfig, first: RecordBatch, drive: tuple[float, float] | None) -> None:
        window, frequency = config.window, first.sampling_frequency
        if window.by == "cycle" and (window.duration is None or window.every is not None):
            length = "give the length of each cycle, counted from its edge, as 'window' alone"
            raise ConfigError(f"by=cycle: {length}")
        self.config, self.first, self.feature = config, first, feature_of(config)
        seen = self.feature.channels | (self.feature.optional_channels & first.channels.keys())
        seen |= {window.channel} if window.by == "cycle" else set()
        seen |= {TEMPERATURE} & first.channels.keys()
        self.channels = tuple(channel for channel in Channel if channel in seen)
        duration = first.duration if window.duration is None else window.duration
        self.n_sample = round(duration * frequency)
        if self.n_sample < 2:
            raise ConfigError(f"window: {duration:g} s at {frequency:g} Hz are fewer than 2 samples")
        self.windower = window.windower(self.n_sample, self.channels, frequency, drive)
        self.durations: list[float] = []
        self.own_groups: list[str] = []
        self.labels: list[str] = []
        self.names: list[str] = []
        self.record: list[int] = []
        self.numbers: list[Array] = []
        self.is_apart: list[bool] = []
        self.all_scores: Array = np.empty(0)
        self.facts: dict[Channel, list[Mapping[str, Array]]] = {}
        self.not_judged: Counter[str] = Counter()
        self.reasons: Counter[str] = Counter()
        self.n_impossible: Counter[str] = Counter()
        self.refused: list[Issue] = []
        self.n_not_positive: Counter[str] = Counter()
        self.fits: dict[str, float] = {}
        self.conditions: dict[str, tuple[float, float]] = {}
        self.clearances: list[float] = []
        self._waiting: list[tuple[int, bool, Window]] = []

    def read(self, batches: Iterable[RecordBatch]) -> None:
        """Score the windows of records."""
        for batch in batches:
            if batch.n_record:
                self._check(batch)
                self._take(batch)
        self._finish()

    def _take(self, batch: RecordBatch) -> None:
        """Score the windows of records; some wait until `_finish`."""
        for row in range(batch.n_record):
            self.durations.append(batch.duration)
            self.own_groups.append(batch.groups[row])
            self.labels.append(batch.labels[row] if batch.labels else "")
            self.names.append(" ".join(dict.fromkeys((batch.sources[row], batch.record_ids[row]))).strip())
            end, nothing = -np.inf, np.full(len(self.feature.numbers), np.nan)
            for window in windows_along(batch, row, self.windower):
                is_apart = bool(window.time[0] > end)
                end = float(window.time[-1]) if is_apart else end
                if window.fault is None:
                    self._waiting.append((len(self.numbers), is_apart, window))
                self.record.append(len(self.durations) - 1)
                self.numbers.append(nothing)
                self.is_apart.append(is_apart)
                if is_apart:
                    self._count(Measured(nothing, window.fault))
                if len(self._waiting) * self.windower.n_sample >= _MOST_SAMPLES:
                    self._finish()

    def _finish(self) -> None:
        """Score all windows that wait."""
        if not self._waiting:
            return
        places, apart, windows = zip(*self._waiting, strict=True)
        self._waiting = []
        channels, are_apart = self.windower.channels, np.array(apart)
        records = records_of(windows, channels, self.windower.sampling_frequency)
        for channel in (each for each in channels if each is not TEMPERATURE and are_apart.any()):
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_apart]))
        for place, is_apart, found in zip(
            places, apart, measured_windows(records, self.feature), strict=True
        ):
            self.numbers[place] = found.numbers
            if is_apart:
                self._count(found)

    def _count(self, found: Measured) -> None:
        """Count faults and doubts of what sets limits, and note its conditions."""
        if found.fault is not None:
            self.not_judged[found.fault.kind] += 1
            self.reasons[found.fault.message] += 1
        if not np.isfinite(found.numbers).all():
            return
        for doubt in found.doubts:
            self.n_impossible[doubt.where] += 1
            self.n_not_positive[doubt.where] += doubt.kind == "not_positive"
        self.refused += self._refusals(found.doubts)[:1]
        for name, value in found.fits.items():
            self.fits[name] = float(np.fmax(self.fits.get(name, value), value))
        doubtful = {doubt.where for doubt in found.doubts}
        sound = {name: value for name, value in found.conditions.items() if name not in doubtful}
        self.conditions = widened(self.conditions, sound)
        self.clearances.append(found.clearance)

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
        if obstacle := without_scale(batch, channels):
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
        return sum(self.durations) / len(self.record)

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
        return [group or f"record {place}" for place, group in enumerate(self.own_groups)]

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Group index of each score that is used to set limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return numbers[np.array(self.record, dtype=np.intp)[self.is_used]]

    @property
    def has_groups(self) -> bool:
        """Whether groups were stated."""
        return any(self.own_groups)


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
