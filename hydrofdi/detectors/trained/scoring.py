"""Scores of healthy records over time, as the detector computes them; samples are not kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.conditions import TEMPERATURE, temperatures, widened
from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.detectors.trained.following import Estimator
from hydrofdi.detectors.trained.measuring import channel_facts, measured_numbers, records_of
from hydrofdi.errors import Issue
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk, EvenStream, TimeWindower, Window, Windower

_CHUNK = 2**17
"""Number of samples of a record that are cut at a time; overlapping windows multiply their memory."""

_MOST_SAMPLES = 2**21
"""Number of samples per channel that are measured at a time."""


class HealthyScores:
    """Scores of healthy records, and statistics of their channels.

    Attributes
    ----------
    durations, own_groups, labels, names : list
        Duration [s], group, label and name of each record; group and label are empty if unknown.
    record : list of int, length n_score
        Index of the record of each window or estimate.
    numbers : list of ndarray, shape (n_number,)
        What is measured of it; NaN if there is none.
    is_apart : list of bool
        Whether it is used to set limits: only non-overlapping windows are.
    all_scores : ndarray, shape (n_score,)
        Set when all numbers are known.
    facts : dict of Channel to list of mapping of str to ndarray, shape (n_window,)
        As from `channel_facts`.
    not_judged, reasons : Counter of str
        Kind of fault and message → number of windows or estimates that have no score.
    n_impossible, n_refused, n_not_positive : Counter of str
        Output → number of windows in which it is impossible, more than a misfit, or not positive.
    fits : dict of str to float
        Output that states how well the model explains a window → largest value.
    conditions : dict of str to (float, float)
        Condition → its lowest and highest value.
    clearances : list of float
        As from `measured_numbers`, of the windows that set limits.
    """

    def __init__(self, feature: Feature, windower: Windower, estimator: Estimator | None = None) -> None:
        self.feature, self.windower, self.estimator = feature, windower, estimator
        self.n_sample = 0 if estimator else windower.n_sample
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
        self.n_refused: Counter[str] = Counter()
        self.n_not_positive: Counter[str] = Counter()
        self.fits: dict[str, float] = {}
        self.conditions: dict[str, tuple[float, float]] = {}
        self.clearances: list[float] = []
        self._waiting: list[tuple[int, bool, Window]] = []

    def take(self, batch: RecordBatch) -> None:
        """Score the windows of records; some wait until `finish`."""
        for row in range(batch.n_record):
            self.durations.append(batch.duration)
            self.own_groups.append(batch.groups[row])
            self.labels.append(batch.labels[row] if batch.labels else "")
            self.names.append(" ".join(dict.fromkeys((batch.sources[row], batch.record_ids[row]))).strip())
            if self.estimator is not None:
                self._follow(self.estimator, batch, row)
            end = -np.inf
            for window in windows_along(batch, row, self.windower):
                is_apart = bool(window.time[0] > end)
                end = float(window.time[-1]) if is_apart else end
                if window.fault is None:
                    self._waiting.append((len(self.numbers), is_apart, window))
                if self.estimator is None:
                    self._add(np.full(len(self.feature.numbers), np.nan), is_apart, window.fault)
                if len(self._waiting) * self.windower.n_sample >= _MOST_SAMPLES:
                    self.finish()

    def finish(self) -> None:
        """Score all windows that wait."""
        if not self._waiting:
            return
        places, apart, windows = zip(*self._waiting, strict=True)
        self._waiting = []
        channels, are_apart = self.windower.channels, np.array(apart)
        records = records_of(windows, channels, self.windower.sampling_frequency)
        for channel in (each for each in channels if each is not TEMPERATURE and are_apart.any()):
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_apart]))
        if self.estimator is not None:
            for row in np.flatnonzero(are_apart).tolist():
                own = {name: float(values[row]) for name, values in temperatures(records).items()}
                self.conditions = widened(self.conditions, own)
            return
        found = measured_numbers(records, self.feature)
        is_known = [bool(each.all()) for each in np.isfinite(found.numbers)]
        for row, place in enumerate(places):
            self.numbers[place] = found.numbers[row]
            if are_apart[row] and is_known[row]:
                self._doubt(found.doubts[row], {name: float(own[row]) for name, own in found.fits.items()})
                own = {name: float(values[row]) for name, values in found.conditions.items()}
                self.conditions = widened(self.conditions, own)
                self.clearances.append(float(found.clearances[row]))
            if are_apart[row] and found.obstacles[row] is not None:
                self._leave_out(Issue(found.obstacles[row] or "", kind="no_number"))

    def _follow(self, estimator: Estimator, batch: RecordBatch, row: int) -> None:
        state = estimator.start()
        for piece in _pieces_along(batch, row, self.windower.channels):
            state, found = estimator.step(state, piece)
            for each in found:
                self._add(np.array([each.score]), True, each.fault)
                self.clearances.append(each.score)
                self._doubt(each.doubts, each.fits)
                self.conditions = widened(self.conditions, each.conditions)

    def _add(self, numbers: Array, is_apart: bool, fault: Issue | None) -> None:
        self.record.append(len(self.durations) - 1)
        self.numbers.append(numbers)
        self.is_apart.append(is_apart)
        if fault is not None and is_apart:
            self._leave_out(fault)

    @property
    def interval(self) -> float:
        """Mean time between scores [s]."""
        if self.estimator is not None:
            return self.estimator.interval
        if isinstance(self.windower, TimeWindower):
            return self.windower.n_every / self.windower.sampling_frequency
        return sum(self.durations) / len(self.record)

    @property
    def duration(self) -> float:
        """Duration of a window, or time between estimates if those are judged [s]."""
        return self.n_sample / self.windower.sampling_frequency if self.n_sample else self.interval

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

    def _doubt(self, doubts: Iterable[Issue], fits: Mapping[str, float]) -> None:
        """Count the doubts about a window."""
        for doubt in doubts:
            self.n_impossible[doubt.where] += 1
            self.n_refused[doubt.where] += doubt.kind != "misfit"
            self.n_not_positive[doubt.where] += doubt.kind == "not_positive"
        for name, value in fits.items():
            self.fits[name] = float(np.fmax(self.fits.get(name, value), value))

    def _leave_out(self, fault: Issue) -> None:
        self.not_judged[fault.kind] += 1
        self.reasons[fault.message] += 1


def windows_along(records: RecordBatch, row: int, windower: Windower) -> Iterator[Window]:
    """Windows of a record, a few at a time."""
    state = windower.start()
    for piece in _pieces_along(records, row, windower.needs):
        state, windows = windower.step(state, piece)
        yield from windows


def _pieces_along(records: RecordBatch, row: int, channels: Collection[Channel]) -> Iterator[Chunk]:
    """Pieces of a record, as from a stream."""
    stream = EvenStream(records.sampling_frequency, tuple(channels))
    state, time = stream.start(), records.time
    for first in range(0, records.n_time, _CHUNK):
        part = slice(first, first + _CHUNK)
        chunk = Chunk(time[part], {channel: records[channel][row, part] for channel in channels})
        state, pieces, _ = stream.step(state, chunk)
        yield from pieces
