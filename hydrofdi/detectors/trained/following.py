"""Estimates of a recursive indicator along a stream, the verdicts on them, and the chart of verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.trained.conditions import TEMPERATURE, estimated_conditions, outside, temperatures
from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.detectors.trained.file import DetectorFile, Scale
from hydrofdi.detectors.trained.measuring import Verdict, findings, verdict_of
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.indicators.recursive import RecursiveIndicator, instants
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Chunk, State, fault_of

_INDICATOR = "indicator."
_HELD = "held"

_LOST, _LOST_AT_FIRST = 10, 600.0
"""Patience before a restart: number of consecutive estimates without a score, after the transient, if the
indicator had a score before; else time since its start [s], because its first window may be long."""

_LEAST_CHECKED_TIME = 1.0
"""Minimum time before an estimate whose samples are checked [s]."""

_BATCH_SIZE = 64
"""Number of estimates that are judged at a time."""


@dataclass(frozen=True)
class Estimate:
    """Estimate of a recursive indicator at an instant.

    Attributes
    ----------
    place : int
        Index of its last sample in the piece.
    time : float
        Time of the estimate, on the clock of the stream [s].
    score : float
        In the unit of the output; NaN if there is a fault.
    fault : Issue or None
        Reason of a restart of the indicator.
    fits, conditions : mapping of str to float
        Outputs that state how well the model explains the samples, and estimated conditions.
    """

    place: int
    time: float
    score: float
    fault: Issue | None = None
    doubts: tuple[Issue, ...] = ()
    fits: Mapping[str, float] = field(default_factory=dict)
    conditions: Mapping[str, float] = field(default_factory=dict)


class Estimator:
    """Computes estimates along a stream; they are bit-identical however the stream is split into pieces.

    The indicator restarts after a gap, after missing samples, and after its score has been missing for long.
    It gives no score during the transient that follows.
    """

    def __init__(
        self,
        feature: Feature,
        channels: Collection[Channel],
        sampling_frequency: float,
        fits: Mapping[str, float] | None = None,
    ) -> None:
        indicator = feature.indicator
        if not isinstance(indicator, RecursiveIndicator):
            raise ConfigError(f"{indicator.name} is not recursive; judge it by windows")
        followed = f"{next(iter(feature.indicators))}.{indicator.estimates[0].name}"
        if feature.label != followed:
            raise ConfigError(f"only {followed} can be judged by estimate, not {feature.label}")
        self.indicator: RecursiveIndicator[Any] = indicator
        self._score, self._channels, self.sampling_frequency = followed, tuple(channels), sampling_frequency
        self._prefix, self._fits = followed.partition(".")[0] + ".", fits
        self._conditions = [*estimated_conditions(feature)]

    def start(self) -> State:
        """State before the first sample: only arrays."""
        none = np.empty((1, 0))
        begun = self.indicator.start(self._records(0, dict.fromkeys(self._channels, none)))
        return {
            "n_seen": np.array([0]),
            "n_lost": np.array([0]),
            "had_score": np.array([False]),
            "is_missing": np.array([False]),
            **{_INDICATOR + name: array for name, array in begun.items()},
        }

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Estimate]]:
        """State after a piece, and the estimates within it; the old state is not modified."""
        state = self.start() if piece.begins_anew else state
        missing = np.vstack([~np.isfinite(piece.channels[channel]) for channel in self._channels])
        found: list[Estimate] = []
        for first, stop, is_missing in _runs(np.any(missing, axis=0)):
            if is_missing:
                if not state["is_missing"][0]:
                    rows = zip(self._channels, missing, strict=True)
                    lost = " and ".join(channel for channel, row in rows if row[first])
                    fault = Issue(f"no sample of {lost}; {self._anew}", kind="missing")
                    found.append(Estimate(first, float(piece.time[first]), np.nan, fault))
                state = {**self.start(), "is_missing": np.array([True])}
                continue
            while first < stop:
                state, first, estimates = self._advance(state, piece, first, stop)
                found += estimates
        return state, found

    def _advance(
        self, state: State, piece: Chunk, first: int, stop: int
    ) -> tuple[State, int, list[Estimate]]:
        """Advance to `stop`, or to the sample at which the indicator restarts."""
        n_before, indicator = int(state["n_seen"][0]), self.indicator
        n_lost, had_score = int(state["n_lost"][0]), bool(state["had_score"][0])
        samples = {
            channel: np.ascontiguousarray(piece.channels[channel][None, first:stop], dtype=float)
            for channel in self._channels
        }
        own = {
            key.removeprefix(_INDICATOR): part for key, part in state.items() if key.startswith(_INDICATOR)
        }
        followed, trace = indicator.step(own, self._records(n_before, samples))
        due = instants(n_before, stop - first, indicator.samples_per_estimate(self.sampling_frequency))
        is_settled = (n_before + due) / self.sampling_frequency >= indicator.options.transient - 1e-9
        found: list[Estimate] = []
        after: dict[str, NDArray[Any]] = {
            "n_seen": np.array([n_before + stop - first]),
            "n_lost": state["n_lost"],
            "had_score": state["had_score"],
            "is_missing": np.array([False]),
            **{_INDICATOR + name: np.asarray(array) for name, array in followed.items()},
        }
        if not is_settled.any():
            return after, stop, found
        values = {self._prefix + name: rows[0, is_settled] for name, rows in trace.values.items()}
        doubts = doubts_of(indicator, values, self._prefix, self._fits)
        fits = [self._prefix + each.name for each in indicator.outputs if each.is_fit]
        for row, place in enumerate(first + due[is_settled]):
            score, fault = float(values[self._score][row]), None
            has_score = math.isfinite(score)
            n_lost, had_score = 0 if has_score else n_lost + 1, had_score or has_score
            patience = indicator.options.transient if had_score else _LOST_AT_FIRST
            is_given_up = n_lost == max(_LOST, math.ceil(patience / self.interval - 1e-9))
            if not has_score:
                lost = f"{self._score} has had no value for {n_lost * self.interval:.4g} s"
                fault = Issue(f"{lost}; {self._anew}" if is_given_up else lost, kind="no_number")
            explained = {name: float(values[name][row]) for name in fits}
            conditions = {name: float(values[name][row]) for name in self._conditions if name in values}
            time = float(piece.time[place])
            found.append(Estimate(int(place), time, score, fault, doubts[row], explained, conditions))
            if is_given_up:
                return self.start(), int(place) + 1, found
        after |= {"n_lost": np.array([n_lost]), "had_score": np.array([had_score])}
        return after, stop, found

    @property
    def interval(self) -> float:
        """Time between estimates [s]."""
        return self.indicator.samples_per_estimate(self.sampling_frequency) / self.sampling_frequency

    @property
    def _anew(self) -> str:
        return f"it restarts and gives no score for {self.indicator.options.transient:g} s"

    def _records(self, n_before: int, samples: Mapping[Channel, Array]) -> RecordBatch:
        return RecordBatch(
            samples, self.sampling_frequency, ("stream",), start_time=n_before / self.sampling_frequency
        )


def _runs(is_missing: NDArray[np.bool_]) -> Iterator[tuple[int, int, bool]]:
    """First, stop and kind of each run of equal flags."""
    bounds = [0, *(np.flatnonzero(np.diff(is_missing)) + 1).tolist(), is_missing.size]
    for first, stop in pairwise(bounds):
        if stop > first:
            yield first, stop, bool(is_missing[first])


class Follower:
    """Judges the estimates of a stream with a trained detector, if the preceding samples are valid.

    Attributes
    ----------
    n_every : int
        Samples from one estimate to the next.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        frequency = file.sampling_frequency
        self._estimator = Estimator(file.feature, file.channels, frequency, file.fits)
        self._n_look = samples_looked_at(self._estimator.indicator, frequency)
        self.n_every = self._estimator.indicator.samples_per_estimate(frequency)

    def start(self) -> State:
        """The state before the first sample: arrays alone."""
        return {_HELD: np.empty((1 + len(self.file.channels), 0)), **self._estimator.start()}

    def step(self, state: State, piece: Chunk) -> tuple[State, Array, list[Verdict]]:
        """State after a piece, the instants of its estimates [s], and a verdict on each."""
        after, found = self._estimator.step(state, piece)
        new = np.stack([piece.time, *(piece.channels[channel] for channel in self.file.channels)])
        rows = new if piece.begins_anew else np.concatenate([state[_HELD], new], axis=1)
        n_held = rows.shape[1] - new.shape[1]
        verdicts: list[Verdict] = []
        for first in range(0, len(found), _BATCH_SIZE):
            some = found[first : first + _BATCH_SIZE]
            faults, warm = self._faults(rows, [n_held + each.place + 1 for each in some])
            for each, fault, mean in zip(some, faults, warm, strict=True):
                verdict = verdict_of(
                    self.file, each.score, each.fault or fault, None, each.doubts, each.conditions
                )
                verdicts.append(replace(verdict, temperature=mean))
        times = np.array([each.time for each in found])
        return {**after, _HELD: rows[:, -self._n_look :].copy()}, times, verdicts

    def _faults(self, rows: Array, stops: Sequence[int]) -> tuple[list[Issue | None], list[float | None]]:
        """Fault of the samples before each of some places, and their mean oil temperature [K].

        None if there are too few samples to check.
        """
        channels, frequency = self.file.channels, self.file.sampling_frequency
        looks = [rows[:, max(0, stop - self._n_look) : stop] for stop in stops]
        faults: list[Issue | None] = [None] * len(looks)
        warm: list[float | None] = [None] * len(looks)
        whole = [place for place, look in enumerate(looks) if look.shape[1] == self._n_look]
        for place in whole:
            time, samples = looks[place][0], looks[place][1:]
            faults[place] = fault_of(time, samples, channels, self._n_look, frequency)
        sound = [place for place in whole if faults[place] is None]
        if sound:
            samples = np.stack([looks[place][1:] for place in sound], axis=1)
            names = tuple(map(str, sound))
            records = RecordBatch(dict(zip(channels, samples, strict=True)), frequency, names)
            means, file = temperatures(records), self.file
            for row, fault in enumerate(findings(records, file.ranges)):
                own = {name: float(values[row]) for name, values in means.items()}
                faults[sound[row]] = fault or outside(file.conditions, file.basis.n_window, own)
                warm[sound[row]] = own.get(TEMPERATURE)
        return faults, warm


def samples_looked_at(indicator: RecursiveIndicator[Any], sampling_frequency: float) -> int:
    """Number of samples before an estimate that are checked: a transient, but at least one second."""
    seconds: float = max(indicator.options.transient, _LEAST_CHECKED_TIME)
    return max(2, round(seconds * sampling_frequency))


@dataclass(frozen=True)
class ChartReading:
    """Reading of the control chart: statistic and limit [healthy spreads], and whether it alarms."""

    statistic: float | None
    limit: float
    alarm: bool


class ScoreChart:
    """Chart of a trained detector that has one. Windows that are not judged do not change it."""

    def __init__(self, file: DetectorFile) -> None:
        assert file.chart is not None
        assert file.config.chart is not None
        assert file.config.direction is not None
        self._chart = make_chart(file.config.chart.chart, file.config.chart.options)
        self._limit, self._healthy = file.chart.limit, file.healthy
        self._direction = file.config.direction

    def start(self) -> State:
        """State before the first window: only arrays."""
        return self._chart.start(1)

    def step(self, state: State, verdict: Verdict) -> tuple[State, ChartReading]:
        """State and reading after a window."""
        judged = math.nan if verdict.alarm is None or verdict.score is None else verdict.score
        score = standardised(judged, self._healthy, self._direction)
        after, statistic = self._chart.step(state, score.reshape(1, 1), self._limit)
        value = float(statistic[0, 0])
        return after, ChartReading(None if math.isnan(value) else value, self._limit, value >= self._limit)


def standardised(scores: ArrayLike, healthy: Scale, direction: Direction) -> Array:
    """Scores in healthy spreads from the healthy median; the sign changes if a leak lowers the score."""
    values = (np.asarray(scores, dtype=float) - healthy.centre) / healthy.spread
    return np.asarray(-values if direction is Direction.FALLING else values)
