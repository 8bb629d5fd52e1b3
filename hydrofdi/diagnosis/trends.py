"""Trend of a score: its history as points, the evidence of a change, and estimates with intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError
from hydrofdi.evaluation.change_point import FEWEST, LAWS, ChangePointModel, Draws, inliers
from hydrofdi.evaluation.scores import Estimate, comparable
from hydrofdi.records.times import FIRST_DATE
from hydrofdi.settings.messages import counted, time_text

Array = NDArray[np.float64]

DAY = 86400.0
"""A day [s]."""

_KNOWN, _VARIES = 0.75, 1.0
"""Least share of points with an oil temperature, and least standard deviation of it [K], to compensate it."""

_MOST_POINTS = 400
"""Most points; more are joined."""
_FEW = 0.1
"""Share of the usual number of scores below which a point is left out."""


@dataclass(frozen=True, eq=False)
class History:
    """Scores over time.

    Attributes
    ----------
    name, meaning : str
        Where they are from, and what the score is.
    unit : str
        SI unit of the score.
    time : ndarray, shape (n,)
        Increasing [s]; since 1970 if it is dated.
    score, temperature : ndarray, shape (n,)
        Score, and oil temperature [K], NaN if it is not known.
    remarks : tuple of str
        What has to be known of the scores.
    """

    name: str
    meaning: str
    unit: str
    time: Array
    score: Array
    temperature: Array
    remarks: tuple[str, ...] = ()

    @property
    def is_dated(self) -> bool:
        """Whether the clock counts from 1970."""
        return bool(self.time[0] >= FIRST_DATE)


@dataclass(frozen=True, eq=False)
class Points:
    """Medians of the scores of equal spans of time.

    Attributes
    ----------
    time, score, temperature : ndarray, shape (n,)
        [s], unit of the score, [K].
    n_score : ndarray, shape (n,)
    is_used : ndarray, shape (n,)
        False for outliers, and for points without oil temperature if that is compensated.
    """

    time: Array
    score: Array
    temperature: Array
    n_score: NDArray[np.int64]
    is_used: NDArray[np.bool_]


def points_of(history: History, span: float) -> tuple[Points, float, list[str]]:
    """Points of a history, their span [s], which may be longer than asked for, and remarks."""
    remarks = list[str]()
    n_most = np.unique(np.floor(comparable(history.time / span))).size
    if n_most > _MOST_POINTS:
        span *= math.ceil(n_most / _MOST_POINTS)
        remarks.append(f"points of {time_or_days(span)}, because there would be more than {_MOST_POINTS}")
    starts = np.flatnonzero(np.diff(np.floor(comparable(history.time / span)), prepend=-np.inf))
    parts = [slice(*ends) for ends in pairwise([*starts.tolist(), history.time.size])]
    counts = np.array([part.stop - part.start for part in parts])
    parts = [part for part, n in zip(parts, counts, strict=True) if n >= _FEW * np.median(counts)]
    if len(parts) < counts.size:
        remarks.append(f"left out: {counted(counts.size - len(parts), 'point')} of few scores")
    warm = [history.temperature[part] for part in parts]
    points = Points(
        np.array([np.median(history.time[part]) for part in parts]),
        np.array([np.median(history.score[part]) for part in parts]),
        np.array([np.mean(part[np.isfinite(part)]) if np.isfinite(part).any() else np.nan for part in warm]),
        np.array([part.stop - part.start for part in parts]),
        np.ones(len(parts), dtype=bool),
    )
    return points, span, remarks


def instant_text(time: float) -> str:
    """An instant for display, a date if it counts from 1970."""
    is_dated = time >= FIRST_DATE
    return f"{datetime.fromtimestamp(time, UTC):%Y-%m-%d %H:%M}" if is_dated else time_text(time)


def time_or_days(seconds: float) -> str:
    """A duration for display."""
    days = seconds / DAY
    return counted(round(days), "day") if days >= 0.995 else time_text(seconds)


@dataclass(frozen=True, eq=False, repr=False)
class TrendEstimates:
    """Estimates of the trend of a score.

    Attributes
    ----------
    history : History
    points : Points
    every : float
        Span of a point [s].
    p_value : float
        Probability of as much evidence of a change in a history without one.
    draws : Draws
        Equally probable courses of the score, with a change if `has_trend`; time in days.
    limit : float or None
        In the unit of the score.
    """

    history: History
    points: Points
    every: float
    p_value: float
    draws: Draws
    limit: float | None
    false_alarm_rate: float
    confidence: float
    is_compensated: bool
    remarks: tuple[str, ...] = ()

    @property
    def has_trend(self) -> bool:
        """Whether a change of the level is shown at the false-alarm rate."""
        return self.p_value <= self.false_alarm_rate

    @property
    def duration(self) -> float:
        """From the first to the last point [s]; nothing is stated for longer than that after the last."""
        return float(self.draws.time[-1] - self.draws.time[0]) * DAY

    def _of(self, draws: Array) -> Estimate:
        return Estimate.of(draws, self.confidence)

    @cached_property
    def onset(self) -> Estimate | None:
        """Beginning of the change [s]; None without a trend."""
        return self._instant(self.draws.onset) if self.has_trend else None

    @cached_property
    def level_before(self) -> Estimate:
        """Level before the change."""
        return self._of(self.draws.level)

    @cached_property
    def level_now(self) -> Estimate:
        """Level at the last point."""
        return self._of(self.draws.level + self.draws.growth)

    @cached_property
    def rate(self) -> Estimate | None:
        """Rate of change at the last point [unit/s]; None without a trend."""
        return self._of(self.draws.rate / DAY) if self.has_trend else None

    @cached_property
    def reached(self) -> Estimate | None:
        """When the level reaches the limit [s].

        −∞: before the history. +∞: not within `duration` after its end. None without a trend or a limit.
        """
        if self.limit is None or not self.has_trend:
            return None
        return self._instant(self.draws.reached(self.limit))

    def _instant(self, days: Array) -> Estimate:
        own = Estimate.of(days, self.confidence, self.draws.spacing)
        return Estimate(*(DAY * day for day in (own.value, own.low, own.high)))

    def probability(self, time: float) -> float:
        """Probability that the level reaches the limit up to an instant [s], at most the horizon."""
        assert self.limit is not None
        return float(np.mean(self.draws.reached(self.limit) <= time / DAY))

    @property
    def horizon(self) -> float:
        """Latest instant of a statement [s]."""
        return float(self.draws.time[-1]) * DAY + self.duration

    @property
    def laws(self) -> dict[str, float]:
        """Name of a law of growth → its probability."""
        shares = np.bincount(self.draws.law, minlength=len(LAWS)) / self.draws.law.size
        names = dict.fromkeys(law.name for law in LAWS)
        return {
            name: float(sum(share for share, law in zip(shares, LAWS, strict=True) if law.name == name))
            for name in names
        }

    @property
    def temperature_effect(self) -> Estimate | None:
        """Change of the score with the oil temperature [unit/K]; None if it is not compensated."""
        return self._of(self.draws.slopes[:, 0]) if self.is_compensated else None


def estimate(
    history: History, span: float, limit: float | None, false_alarm_rate: float, confidence: float
) -> TrendEstimates:
    """Estimates of the trend of a history, in points of a span [s].

    Raises
    ------
    DataError
        The history has too few points.
    """
    points, span, remarks = points_of(history, span)
    known = np.isfinite(points.temperature)
    is_compensated = bool(
        known.mean() >= _KNOWN and np.std(points.temperature[known]) >= _VARIES and known.sum() >= FEWEST
    )
    used = known if is_compensated else np.ones(known.size, dtype=bool)
    if used.sum() < FEWEST:
        few = (
            f"{history.name}: has {counted(int(used.sum()), 'point')} of {time_or_days(span)}; a trend needs"
            f" {FEWEST} or more: state a shorter span with 'every', or wait"
        )
        raise DataError("; ".join([few, *history.remarks]))
    is_used = used.copy()
    is_used[used] = inliers(points.score[used])
    points, used = replace(points, is_used=is_used), is_used
    scores, warm = points.score[used], points.temperature[used] if is_compensated else None
    model = ChangePointModel(points.time[used] / DAY, warm)
    p_value = model.p_value(scores)
    draws = model.draws(scores, is_changed=p_value <= false_alarm_rate)
    if not is_compensated:
        remarks.append("the oil temperature is not compensated: its seasons may look like a trend")
    notes = (*history.remarks, *remarks)
    return TrendEstimates(
        history, points, span, p_value, draws, limit, false_alarm_rate, confidence, is_compensated, notes
    )
