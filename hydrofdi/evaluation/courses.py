"""Courses of a level that grows from an onset on, and when they reach a limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True)
class Law:
    """Growth over the share s of the time from the onset to the last point, 1 at s = 1.

    s^p, or (exp(k s) − 1)/(exp(k) − 1) if k > 0, in which the rate grows with the leak itself.
    """

    name: str
    prior: float
    power: float = 0.0
    pace: float = 0.0


LAWS = (
    Law("sudden", 1 / 3),
    Law("linear", 1 / 3, power=1.0),
    *(Law("accelerating", 1 / 18, power=power) for power in (1.5, 2.0, 3.0)),
    *(Law("accelerating", 1 / 18, pace=pace) for pace in (2.0, 4.0, 6.0)),
)
"""Laws of growth, with their probabilities before the data are seen: thirds for their names."""

_POWERS, _PACES = (np.array([getattr(law, name) for law in LAWS]) for name in ("power", "pace"))


def grown(time: Array, onset: Array, law: NDArray[np.int64], last: float) -> Array:
    """Share of the growth until `last`, shape (n_time, n_change)."""
    since, power, pace = time[:, None] - onset, _POWERS[law], _PACES[law]
    share = np.maximum(since, 0.0) / (last - onset)
    with np.errstate(over="ignore", invalid="ignore"):
        # Both forms are computed for all; without a pace the first is 0/0.
        rising = np.where(pace > 0.0, np.expm1(pace * share) / np.expm1(pace), share**power)
    # A sudden change is s^0, which is 1 before the onset as well.
    return np.where(since > 0.0, rising, 0.0)


@dataclass(frozen=True, eq=False)
class Draws:
    """Equally probable courses of the level, each of shape (n_draw,).

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants of the series.
    level, growth : ndarray
        Level before the onset, and its growth until the last point.
    onset, law : ndarray
        Onset, and place in `LAWS`.
    slopes : ndarray, shape (n_draw, n_covariate)
        Change of the level with a covariate.
    deviation : ndarray
        Standard deviation of single points.
    """

    time: Array
    level: Array
    growth: Array
    onset: Array
    law: NDArray[np.int64]
    slopes: Array
    deviation: Array

    @property
    def spacing(self) -> float:
        """Half the median distance of points: an instant within the series is known no better."""
        return float(np.median(np.diff(self.time))) / 2.0

    def levels(self, time: ArrayLike) -> Array:
        """The level at instants, shape (n_time, n_draw)."""
        share = grown(np.asarray(time, dtype=float), self.onset, self.law, self.time[-1])
        return np.asarray(self.level + self.growth * share)

    @property
    def rate(self) -> Array:
        """Derivative of the level at the last point; 0 after a step."""
        pace = _PACES[self.law]
        with np.errstate(invalid="ignore"):
            # k e^k/(e^k − 1) in a form that cannot overflow.
            slope = np.where(pace > 0.0, -pace / np.expm1(-pace), _POWERS[self.law])
        return np.asarray(self.growth * slope / (self.time[-1] - self.onset))

    def reached(self, limit: float) -> Array:
        """Instant at which the level reaches a limit from the side of the growth.

        −∞ if it was beyond before; +∞ if it does so never, or later than the length of the history after its
        end.
        """
        last, pace, is_sudden = self.time[-1], _PACES[self.law], np.equal(self.law, 0)
        # The side of most draws, so that all face the limit from the same one.
        side = np.sign(np.median(self.growth)) or 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (limit - self.level) / self.growth
            root = np.maximum(share, 0.0) ** (1.0 / _POWERS[self.law])
            place = np.where(pace > 0.0, np.log1p(np.maximum(share, 0.0) * np.expm1(pace)) / pace, root)
        place = np.where(is_sudden, np.where(share <= 1.0, 0.0, np.inf), place)
        at = self.onset + (last - self.onset) * place
        at = np.where((share >= 0.0) & (at <= 2.0 * last - self.time[0]), at, np.inf)
        return np.where(side * (self.level - limit) >= 0.0, -np.inf, at)


@dataclass(frozen=True)
class Estimate:
    """A median with an interval; ends may be infinite."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, draws: Array, confidence: float, margin: float = 0.0) -> Estimate:
        """That of equally probable values, widened by a margin."""
        tail = (1.0 - confidence) / 2.0
        # An order statistic, as infinite values cannot be interpolated.
        low, high = np.quantile(draws, tail, method="lower"), np.quantile(draws, 1.0 - tail, method="higher")
        value = np.quantile(draws, 0.5, method="nearest")
        return cls(float(value), float(low) - margin, float(high) + margin)
