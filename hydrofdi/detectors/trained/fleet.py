"""Limits of a machine with few records of its own, from these and from a fleet: empirical Bayes.

Scores of a machine are normal with mean m and deviation s. Over the fleet m and ln s are normal; their means
and deviations are estimated from the fleet: Gelman et al., Bayesian Data Analysis (2013), chapter 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.trained.file import Fleet, Limits, Scale
from hydrofdi.evaluation.roc import FEWEST_GROUPS
from hydrofdi.evaluation.scores import Direction
from hydrofdi.records import Array

_REACH, _N_SPREAD, _N_GRID, _N_MEAN = 6.0, 200, 3, 128
"""Reach of the grid of ln s in deviations; numbers of its nodes, of grids, and of nodes of m."""

_LEAST_WEIGHT = 1e-12
"""Least weight of a node that is kept, relative to the largest."""


def fleet_of(scores: ArrayLike, groups: ArrayLike) -> Fleet | None:
    """Mean and spread over machines of the mean and of the log deviation of scores within a machine.

    Parameters
    ----------
    scores, groups : array_like, shape (n_score,)
        Healthy scores, and the machine of each. Machines with one score are left out.

    Returns
    -------
    Fleet or None
        None if fewer than five machines have two scores that differ.
    """
    from scipy.special import digamma, polygamma

    values, names = np.asarray(scores, dtype=float), np.asarray(groups)
    rows = [own for name in np.unique(names) if (own := values[names == name]).size > 1 and np.ptp(own) > 0.0]
    if len(rows) < FEWEST_GROUPS:
        return None
    means, variances = (np.array([part(own) for own in rows]) for part in (np.mean, _variance))
    half = np.array([own.size - 1 for own in rows]) / 2.0
    # bias and variance of ln s of normal scores
    logs = np.log(variances) / 2.0 - (digamma(half) - np.log(half)) / 2.0
    sizes = np.array([own.size for own in rows])
    return Fleet(
        n_machine=len(rows),
        mean=float(means.mean()),
        mean_deviation=_between(means, variances / sizes),
        log_deviation=float(logs.mean()),
        log_deviation_deviation=_between(logs, polygamma(1, half) / 4.0),
    )


def _variance(own: Array) -> float:
    return float(own.var(ddof=1))


def _between(found: Array, sampling: Array) -> float:
    """Deviation over machines without sampling errors, widened as its own estimate is uncertain."""
    n, observed = found.size, float(found.var(ddof=1))
    # not less than the standard error of the observed variance: the difference may be negative
    between = max(observed - float(sampling.mean()), observed * math.sqrt(2.0 / (n - 1.0)), 1e-300)
    # a new machine differs by a Student variable with n − 1 degrees of freedom; the same variance
    return math.sqrt(between * (1.0 + 1.0 / n) * (n - 1.0) / (n - 3.0))


@dataclass(frozen=True)
class Posterior:
    """What own scores and a fleet say of a machine: nodes of s with weights, and normal m at each.

    Attributes
    ----------
    weights, deviations, means, errors : ndarray, shape (n_node,)
        Weight and value of s; mean and deviation of m.
    """

    weights: Array
    deviations: Array
    means: Array
    errors: Array

    @property
    def scale(self) -> tuple[float, float]:
        """Expected mean and deviation of the scores of the machine."""
        return float(self.weights @ self.means), float(self.weights @ self.deviations)

    def high(self, rate: float) -> float:
        """Limit that the next score exceeds with a probability."""
        from scipy.optimize import brentq
        from scipy.special import ndtr, ndtri

        spread = np.hypot(self.deviations, self.errors)
        ends = self.means - ndtri(rate) * spread
        if ends.min() == ends.max():
            return float(ends[0])
        excess = lambda limit: float(self.weights @ ndtr((self.means - limit) / spread)) - rate  # noqa: E731
        return float(brentq(excess, ends.min(), ends.max(), xtol=1e-12 * float(np.ptp(ends)), maxiter=500))

    def rate_interval(self, low: float, high: float, confidence: float) -> tuple[float, float]:
        """Interval of the true rate of scores beyond limits."""
        from scipy.special import ndtr, ndtri

        nodes = ndtri((np.arange(_N_MEAN) + 0.5) / _N_MEAN)
        means = self.means[:, None] + self.errors[:, None] * nodes
        spread = self.deviations[:, None]
        rates = np.ravel(ndtr((means - high) / spread) + ndtr((low - means) / spread))
        order = np.argsort(rates)
        below = np.cumsum(np.repeat(self.weights / _N_MEAN, _N_MEAN)[order])
        ends = np.searchsorted(below, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
        least, most = rates[order][np.minimum(ends, rates.size - 1)].tolist()
        return least, min(1.0, most)


def posterior(scores: ArrayLike, fleet: Fleet) -> Posterior:
    """What a machine of the fleet with some scores of its own is like.

    Parameters
    ----------
    scores : array_like, shape (n_score,)
        Own healthy scores, at least one.
    """
    own = np.asarray(scores, dtype=float)
    n, mean, dof = own.size, float(own.mean()), own.size - 1
    variance = float(own.var(ddof=1)) if dof else 0.0
    centre, width = fleet.log_deviation, fleet.log_deviation_deviation
    between, ends = fleet.mean_deviation**2, (centre - _REACH * width, centre + _REACH * width)
    # the grid is refined to the nodes with weight: many own scores leave a small part of the prior
    for _ in range(_N_GRID):
        logs = np.linspace(*ends, _N_SPREAD)
        squares = np.exp(2.0 * logs)
        total = between + squares / n
        log_weights = (
            -(((logs - centre) / width) ** 2) / 2.0
            - dof * (logs + variance / squares / 2.0)
            - np.log(total) / 2.0
            - (mean - fleet.mean) ** 2 / total / 2.0
        )
        weights = np.exp(log_weights - log_weights.max())
        known = weights > _LEAST_WEIGHT
        first, last = np.flatnonzero(known)[[0, -1]].tolist()
        ends = float(logs[max(first - 1, 0)]), float(logs[min(last + 1, _N_SPREAD - 1)])
    weights, shrinkage = weights[known], between / total[known]
    return Posterior(
        weights / weights.sum(),
        np.exp(logs[known]),
        fleet.mean + shrinkage * (mean - fleet.mean),
        np.sqrt(shrinkage * squares[known] / n),
    )


def fleet_limits(
    scores: NDArray[np.float64], fleet: Fleet, direction: Direction, rate: float, confidence: float
) -> tuple[Limits, Scale]:
    """Limits and healthy scale of a machine from its own scores and a fleet."""
    found, each = posterior(scores, fleet), rate / direction.n_side
    turned = Posterior(found.weights, found.deviations, -found.means, found.errors)
    low = -math.inf if direction is Direction.RISING else -turned.high(each)
    high = math.inf if direction is Direction.FALLING else found.high(each)
    centre, spread = found.scale
    limits = Limits(
        low=low if math.isfinite(low) else None,
        high=high if math.isfinite(high) else None,
        false_alarm_rate=rate,
        interval=found.rate_interval(low, high, confidence),
        confidence=confidence,
        method="posterior predictive",
        interval_rests_on="fleet",
    )
    return limits, Scale(centre=centre, spread=spread, range=(float(scores.min()), float(scores.max())))
