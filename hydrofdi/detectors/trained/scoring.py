"""Scores of healthy records over time, as the detector computes them; samples are not kept."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.detectors.trained.following import Estimator, samples_looked_at
from hydrofdi.detectors.trained.measuring import (
    ChannelFacts,
    channel_facts,
    measured_numbers,
    records_of,
)
from hydrofdi.errors import Issue
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk, EvenStream, TimeWindower, Window, Windower

_CHUNK = 2**17
"""Number of samples of a record that are cut at a time; overlapping windows multiply their memory."""

_MOST_SAMPLES = 2**21
"""Number of samples per channel that are measured at a time."""


@dataclass(eq=False)
class ScoreLine:
    """Scores of a record over time.

    Attributes
    ----------
    duration : float
        Duration of the record [s].
    group, label : str
        Empty if unknown.
    numbers : list of ndarray, shape (n_number,)
        What is measured of each window; NaN if there is none.
    scores : ndarray, shape (n_window,)
        Set when all numbers are known.
    is_apart : list of bool
        Whether a score is used to set limits: only those of non-overlapping windows are.
    """

    duration: float
    group: str
    label: str
    numbers: list[Array] = field(default_factory=list)
    scores: Array = field(default_factory=lambda: np.empty(0))
    is_apart: list[bool] = field(default_factory=list)

    def add(self, numbers: Array, is_apart: bool) -> int:
        """Append a window, and return its index."""
        self.numbers.append(numbers)
        self.is_apart.append(is_apart)
        return len(self.numbers) - 1

    @cached_property
    def chosen(self) -> Array:
        """Scores that are used to set limits."""
        return self.scores[np.array(self.is_apart, dtype=bool) & ~np.isnan(self.scores)]


class HealthyScores(ABC):
    """Scores of healthy records, and statistics of their channels.

    Parameters
    ----------
    n_sample : int
        Samples per window; 0 if estimates are judged.
    channels : sequence of Channel
        Channels that a window needs.

    Attributes
    ----------
    lines : list of ScoreLine
    facts : dict of Channel to list of ChannelFacts
    not_judged, reasons : Counter of str
        Kind of fault and message → number of windows or estimates that have no score.
    n_impossible, n_not_positive : Counter of str
        Output → number of windows in which it is physically impossible, or in particular not positive.
    fits : dict of str to float
        Output that states how well the model explains a window → largest value.
    """

    def __init__(self, n_sample: int, channels: Sequence[Channel]) -> None:
        self.n_sample, self.channels = n_sample, tuple(channels)
        self.lines: list[ScoreLine] = []
        self.facts: dict[Channel, list[ChannelFacts]] = {}
        self.not_judged: Counter[str] = Counter()
        self.reasons: Counter[str] = Counter()
        self.n_impossible: Counter[str] = Counter()
        self.n_not_positive: Counter[str] = Counter()
        self.fits: dict[str, float] = {}

    def take(self, batch: RecordBatch) -> None:
        """Score the windows of records; some may wait until `finish`."""
        for row in range(batch.n_record):
            line = ScoreLine(batch.duration, batch.groups[row], batch.labels[row] if batch.labels else "")
            self.lines.append(line)
            self._score(line, batch, row)

    @abstractmethod
    def _score(self, line: ScoreLine, batch: RecordBatch, row: int) -> None:
        """Add the scores of a record."""

    @abstractmethod
    def finish(self) -> None:
        """Score what is waiting."""

    @property
    @abstractmethod
    def interval(self) -> float:
        """Mean time between scores [s]."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Duration of a window, or time between estimates if those are judged [s]."""

    @property
    def numbers(self) -> Array:
        """Numbers of all windows, shape (n_window, n_number)."""
        return np.array([numbers for line in self.lines for numbers in line.numbers])

    @property
    def is_apart(self) -> NDArray[np.bool_]:
        """Whether each window is used to set limits, shape (n_window,)."""
        return np.array([each for line in self.lines for each in line.is_apart], dtype=bool)

    def set_scores(self, scores: Array) -> None:
        """Set the scores of all windows, shape (n_window,)."""
        places = np.cumsum([len(line.numbers) for line in self.lines])
        for line, own in zip(self.lines, np.split(scores, places[:-1]), strict=True):
            line.scores = own

    @cached_property
    def scores(self) -> Array:
        """All scores that are used to set limits."""
        return np.concatenate([line.chosen for line in self.lines] or [np.empty(0)])

    @property
    def hours(self) -> float:
        """Time that has scores [h]."""
        n_score = sum(int(np.isfinite(line.scores).sum()) for line in self.lines)
        return n_score * self.interval / 3600.0 if n_score else 0.0

    @cached_property
    def groups(self) -> list[str]:
        """Group of each record; a record without a group is its own group."""
        return [line.group or f"record {place}" for place, line in enumerate(self.lines)]

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Group index of each score that is used to set limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return np.repeat(numbers, [line.chosen.size for line in self.lines])

    @property
    def has_groups(self) -> bool:
        """Whether groups were stated."""
        return any(line.group for line in self.lines)

    def _doubt(self, doubts: Iterable[Issue], fits: Mapping[str, float]) -> None:
        """Count the doubts about a window."""
        for doubt in doubts:
            self.n_impossible[doubt.where] += doubt.kind != "misfit"
            self.n_not_positive[doubt.where] += doubt.kind == "not_positive"
        for name, value in fits.items():
            self.fits[name] = float(np.fmax(self.fits.get(name, value), value))

    def _leave_out(self, fault: Issue) -> None:
        self.not_judged[fault.kind] += 1
        self.reasons[fault.message] += 1


class WindowScores(HealthyScores):
    """Scores of windows, measured in batches."""

    def __init__(self, windower: Windower, feature: Feature) -> None:
        super().__init__(windower.n_sample, windower.channels)
        self.windower, self.feature = windower, feature
        self._waiting: list[tuple[ScoreLine, int, Window]] = []

    def _score(self, line: ScoreLine, batch: RecordBatch, row: int) -> None:
        end = -np.inf
        for window in windows_along(batch, row, self.windower):
            is_apart = bool(window.time[0] > end)
            end = float(window.time[-1]) if is_apart else end
            place = line.add(np.full(len(self.feature.numbers), np.nan), is_apart)
            if window.fault is None:
                self._waiting.append((line, place, window))
            elif is_apart:
                self._leave_out(window.fault)
            if len(self._waiting) * self.n_sample >= _MOST_SAMPLES:
                self.finish()

    def finish(self) -> None:
        """Score all pending windows."""
        if not self._waiting:
            return
        windows = [window for _, _, window in self._waiting]
        are_apart = np.array([line.is_apart[place] for line, place, _ in self._waiting])
        records = records_of(windows, self.channels, self.windower.sampling_frequency)
        found = measured_numbers(records, self.feature)
        is_known = np.isfinite(found.numbers).all(axis=1)
        for channel in self.channels if are_apart.any() else ():
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_apart]))
        for row in np.flatnonzero(are_apart & is_known).tolist():
            self._doubt(found.doubts[row], {name: float(own[row]) for name, own in found.fits.items()})
        for (line, place, _), numbers, obstacle in zip(
            self._waiting, found.numbers, found.obstacles, strict=True
        ):
            line.numbers[place] = numbers
            if obstacle is not None and line.is_apart[place]:
                self._leave_out(Issue(obstacle, kind="no_number"))
        self._waiting = []

    @property
    def interval(self) -> float:
        """Mean time between scores [s]."""
        if isinstance(self.windower, TimeWindower):
            return self.windower.n_every / self.windower.sampling_frequency
        return sum(line.duration for line in self.lines) / sum(len(line.numbers) for line in self.lines)

    @property
    def duration(self) -> float:
        """Duration of a window [s]."""
        return self.n_sample / self.windower.sampling_frequency


class EstimateScores(HealthyScores):
    """Estimates of a recursive indicator, and statistics of the samples before them."""

    def __init__(self, estimator: Estimator, channels: Sequence[Channel]) -> None:
        super().__init__(0, channels)
        self.estimator = estimator
        n_look = samples_looked_at(estimator.indicator, estimator.sampling_frequency)
        self._looks = TimeWindower(n_look, n_look, self.channels, estimator.sampling_frequency)

    def _score(self, line: ScoreLine, batch: RecordBatch, row: int) -> None:
        state = self.estimator.start()
        for piece in _pieces_along(batch, row, self.channels):
            state, found = self.estimator.step(state, piece)
            for each in found:
                line.add(np.array([each.score]), is_apart=True)
                self._doubt(each.doubts, each.fits)
                if each.fault is not None:
                    self._leave_out(each.fault)
        for window in windows_along(batch, row, self._looks):
            for channel in self.channels if window.fault is None else ():
                self.facts.setdefault(channel, []).append(channel_facts(window.channels[channel][None]))

    def finish(self) -> None:
        """Nothing waits."""

    @property
    def interval(self) -> float:
        """Time between estimates [s]."""
        return self.estimator.interval

    duration = interval


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
