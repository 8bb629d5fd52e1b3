"""Estimates of a trend: onset, level, rate and when a limit is reached, with intervals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hydrofdi.api.histories import DAY, History, Points
from hydrofdi.evaluation.change_point import LAWS, Draws, Estimate
from hydrofdi.records import Array


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
        found = Estimate.of(days, self.confidence, self.draws.spacing)
        return Estimate(*(DAY * each for each in (found.value, found.low, found.high)))

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
