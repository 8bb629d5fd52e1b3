"""Thresholds of scores from healthy records."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, Direction, comparable, measurable


def time_needed(false_alarm_every: float, confidence: float) -> float:
    """Alarm-free time that demonstrates a mean time between false alarms, in the same unit."""
    # Poisson: no alarm within t has the probability e^(−t/T).
    return -math.log(1.0 - confidence) * false_alarm_every


def records_needed(false_alarm_rate: float, confidence: float, rank: int = 1) -> int:
    """Smallest n for which the `rank`-th largest of n scores is a tolerance limit.

    Parameters
    ----------
    rank : int
        Rank, at least 1.
    """
    # The range is lazy: bisection evaluates about fifty of its numbers.
    return bisect_left(
        range(2**50), comparable(confidence), rank, key=lambda n: _confidence_at(rank, n, false_alarm_rate)
    )


def tolerance_threshold(
    healthy: ArrayLike,
    false_alarm_rate: float,
    *,
    confidence: float = 0.95,
    direction: Direction = Direction.RISING,
) -> Threshold:
    """Lowest order statistic whose false-alarm rate is at most α with confidence γ.

    The rate of the k-th largest of n scores is distributed as Beta(k, n + 1 - k), so k is the largest rank
    with P(Beta ≤ α) ≥ γ: Wilks, Annals of Mathematical Statistics 12 (1941) 91. For both directions, only the
    total number of scores outside matters; half of them lie beyond each limit. The interval of the threshold
    is one-sided.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
        Scores of independent fit records.
    false_alarm_rate : float
        α.
    confidence : float
        γ.
    """
    from scipy.special import betaincinv

    known, missing = measurable(healthy)
    sides, asked = direction.n_side, comparable(confidence)
    ranks = range(known.size + 1)
    # The confidence falls with the rank, so bisection finds the first rank that fails.
    fails = bisect_left(
        ranks, True, 1, key=lambda rank: _confidence_at(rank, known.size, false_alarm_rate) < asked
    )
    rank = (fails - 1) // sides * sides
    if not rank:
        needed = records_needed(false_alarm_rate, confidence, sides)
        raise NotStatedError(
            f"a false-alarm rate of at most {100.0 * false_alarm_rate:.3g} % with {100.0 * confidence:.4g} %"
            f" confidence needs {needed} healthy records, not {known.size}",
            needed,
        )
    bound = float(betaincinv(rank, known.size + 1 - rank, confidence))
    limits = limits_at_rank(np.sort(known), rank, direction)
    return Threshold(*limits, (0.0, bound), confidence, known.size, missing, "tolerance limit")


def _confidence_at(rank: int, n: int, false_alarm_rate: float) -> float:
    from scipy.special import betainc

    return float(comparable(betainc(rank, n + 1 - rank, false_alarm_rate)))


@dataclass(frozen=True)
class Threshold:
    """Limits beyond which a score raises an alarm.

    Attributes
    ----------
    low, high : float
        Scores below `low` or above `high` raise an alarm, scores on a limit do not; infinite if the direction
        has no such limit.
    interval : tuple of float
        Interval of the true rate, at level `confidence`.
    n_healthy : int
        Number of healthy records used.
    not_measurable : int
        Number of further healthy records without a score.
    method : str
        ``quantile``, ``tolerance limit`` or ``tail model``.
    """

    low: float
    high: float
    interval: tuple[float, float]
    confidence: float
    n_healthy: int
    not_measurable: int
    method: str

    def outcomes(self, scores: ArrayLike) -> Array:
        """1 if a score is an alarm, 0 if not, NaN if it cannot be measured."""
        values = np.asarray(scores, dtype=float)
        alarms = (values < self.low) | (values > self.high)
        return np.where(np.isnan(values), np.nan, alarms.astype(float))


def limits_at_rank(ordered: Array, rank: int, direction: Direction) -> tuple[float, float]:
    """Limits with `rank` - 1 scores outside; for both directions, `rank` - 2 scores, half on each side.

    Parameters
    ----------
    ordered : ndarray, shape (n,)
        Ascending.
    rank : int
        From 1; even for both directions.
    """
    each = rank // direction.n_side
    low = -math.inf if direction is Direction.RISING else float(ordered[each - 1])
    high = math.inf if direction is Direction.FALLING else float(ordered[-each])
    return low, high


def quantile_threshold(
    healthy: ArrayLike,
    false_alarm_rate: float,
    *,
    direction: Direction = Direction.RISING,
    confidence: float = 0.95,
) -> Threshold:
    """Threshold at the k-th largest of n healthy scores, with k = ⌊α (n + 1)⌋.

    Averaged over fit sets, the false-alarm rate is k/(n + 1) ≤ α; for one fit set it is distributed as
    Beta(k, n + 1 - k), for any distribution of the scores: David and Nagaraja, Order Statistics (2003),
    section 2.1. Ties only lower it.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
        Scores of independent fit records.
    false_alarm_rate : float
        α.
    direction : Direction
        For both directions, k/2 scores are beyond each limit.
    confidence : float
        Confidence level of the two-sided interval of the true rate.
    """
    from scipy.special import betaincinv

    known, missing = measurable(healthy)
    sides = direction.n_side
    # Without the tolerance, rounding just below a whole number would cost a rank.
    rank = math.floor(false_alarm_rate * (known.size + 1) / sides + 1e-9) * sides
    if not rank:
        needed = math.ceil(sides / false_alarm_rate - 1e-9) - 1
        raise NotStatedError(
            f"a false-alarm rate of {100.0 * false_alarm_rate:.3g} % needs {needed} healthy records,"
            f" not {known.size}",
            needed,
        )
    tails = np.array([1.0 - confidence, 1.0 + confidence]) / 2.0
    low, high = betaincinv(rank, known.size + 1 - rank, tails)
    limits = limits_at_rank(np.sort(known), rank, direction)
    return Threshold(*limits, (float(low), float(high)), confidence, known.size, missing, "quantile")


@dataclass(frozen=True, eq=False)
class GeneralisedPareto:
    """Distributions P(Y > y) = (1 + ξ y/σ)^(-1/ξ) of excesses: Pickands, Annals of Statistics 3 (1975) 119.

    Attributes
    ----------
    shape : ndarray, shape (...,)
        ξ.
    scale : ndarray, shape (...,)
        σ, in the unit of the scores.
    """

    shape: Array
    scale: Array

    def survival(self, excess: Array) -> Array:
        """P(Y > excess), shape (..., n)."""
        shape, scale = self.shape[..., None], self.scale[..., None]
        safe = _away_from_zero(shape)
        # Beyond the end of a bounded tail (ξ < 0) the growth is 0, and so is the probability.
        growth = np.maximum(1.0 + safe * excess / scale, 0.0)
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-np.log(growth) / safe))

    def excess(self, survival: Array) -> Array:
        """Excess that is exceeded with probability `survival`, shape (..., n)."""
        shape, scale = self.shape[..., None], self.scale[..., None]
        safe = _away_from_zero(shape)
        # expm1, as s^(−ξ) − 1 cancels at small ξ.
        return np.asarray(scale * np.expm1(-safe * np.log(survival)) / safe)


def fit_generalised_pareto(excesses: Array) -> GeneralisedPareto:
    """Fit distributions to rows of excesses.

    Method of Zhang and Stephens, Technometrics 51 (2009) 316.

    A likelihood-weighted mean over a grid of ξ/σ: as efficient as maximum likelihood, and always defined.

    Parameters
    ----------
    excesses : ndarray, shape (..., n)
        Ascending along the last axis, with a positive lower quartile.
    """
    n = excesses.shape[-1]
    n_grid = 20 + int(np.sqrt(n))
    quartile = excesses[..., int(n / 4.0 + 0.5) - 1]
    nodes = 1.0 - np.sqrt(n_grid / (np.arange(1, n_grid + 1) - 0.5))
    # Trials of −ξ/σ, all below 1 over the largest excess, so that no logarithm is of a negative number.
    ratios = 1.0 / excesses[..., -1, None] + nodes / (3.0 * quartile[..., None])
    shapes = np.stack([_shape_at(ratio, excesses) for ratio in np.moveaxis(ratios, -1, 0)], axis=-1)
    likelihood = n * (np.log(-ratios / shapes) - shapes - 1.0)
    # Over the largest likelihood, so that none overflows.
    weights = np.exp(likelihood - likelihood.max(axis=-1, keepdims=True))
    ratio = np.sum(ratios * weights, axis=-1) / weights.sum(axis=-1)
    shape = _shape_at(ratio, excesses)
    return GeneralisedPareto(shape, -shape / ratio)


def anderson_darling(distribution: GeneralisedPareto, excesses: Array) -> Array:
    """Anderson-Darling statistic A², which emphasises the tails.

    Annals of Mathematical Statistics 23 (1952) 193.

    Parameters
    ----------
    excesses : ndarray, shape (..., n)
        Ascending along the last axis.
    """
    n = excesses.shape[-1]
    # Probabilities of 0 and 1 would have infinite logarithms.
    above = np.clip(distribution.survival(excesses), 1e-300, 1.0 - 1e-16)
    terms = np.log1p(-above) + np.log(above[..., ::-1])
    return np.asarray(-n - np.sum((2.0 * np.arange(1, n + 1) - 1.0) * terms, axis=-1) / n)


def _shape_at(ratio: Array, excesses: Array) -> Array:
    return np.asarray(np.mean(np.log1p(-ratio[..., None] * excesses), axis=-1))


def _away_from_zero(shape: Array) -> Array:
    """Replace ξ = 0 by ±1e-9, which is accurate to nine digits."""
    return np.where(np.abs(shape) < 1e-9, 1e-9, shape)


TAIL_SHARE = 0.1
"""Largest fraction of the records in the tail: DuMouchel, Annals of Statistics 11 (1983) 1019."""

FEWEST, MOST = 50, 500
"""Minimum and maximum number of records in the tail."""

EXTRAPOLATION = 10.0
"""Largest factor by which a rate may be below 1/n."""

N_BOOTSTRAP = 400


def tail_threshold(
    healthy: ArrayLike,
    false_alarm_rate: float,
    *,
    direction: Direction = Direction.RISING,
    confidence: float = 0.95,
    significance: float = 0.05,
    seed: int = 0,
) -> Threshold:
    """Threshold that a generalised Pareto tail exceeds at rate α.

    u + σ/ξ ((α/ζ)^(-ξ) - 1), with ζ the fraction of scores above u: Coles, An Introduction to Statistical
    Modeling of Extreme Values (2001), section 4.3. A parametric bootstrap of the fitted tail gives the
    interval of the true rate and the distribution of the Anderson-Darling statistic A²: Stute, Gonzáles
    Manteiga and Presedo Quindimil, Metrika 40 (1993) 243.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
        Scores of independent fit records.
    false_alarm_rate : float
        α.
    direction : Direction
        Both directions take α/2 from each tail.
    confidence : float
        Confidence level of the two-sided interval of the true rate. Nominal 95 % intervals covered the rate
        in 90 to 96 of 100 repeats with exponential, normal and t₃ scores; coverage is lower for bounded
        tails, such as uniform ones.
    significance : float
        The model is rejected if A² exceeds its (1 − significance) quantile in the bootstrap.
    seed : int
        Seed of the bootstrap.
    """
    known, missing = measurable(healthy)
    rate = false_alarm_rate / direction.n_side
    n_tail = _tail_size(known.size, rate)
    draw = np.random.default_rng(seed)
    low, high, rates = -math.inf, math.inf, np.zeros(N_BOOTSTRAP)
    if direction is not Direction.FALLING:
        high, drawn = _one_tail(known, n_tail, rate, significance, draw)
        rates = rates + drawn
    if direction is not Direction.RISING:
        # The lower tail is the upper one of the negated scores.
        limit, drawn = _one_tail(-known, n_tail, rate, significance, draw)
        low, rates = -limit, rates + drawn
    least, most = np.quantile(rates, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    interval = (float(least), float(most))
    return Threshold(low, high, interval, confidence, known.size, missing, "tail model")


def _tail_size(n: int, rate: float) -> int:
    needed = max(math.ceil(FEWEST / TAIL_SHARE), math.ceil(1.0 / (EXTRAPOLATION * rate) - 1e-9))
    if n < needed:
        raise NotStatedError(
            f"a tail model at a rate of {100.0 * rate:.3g} % needs {needed} healthy records, not {n}", needed
        )
    n_tail = min(int(n * TAIL_SHARE), MOST)
    if rate >= n_tail / n:
        raise NotStatedError(
            f"a rate of {rate:.3g} is not rare enough for a tail model of {n} records: use a tolerance limit"
        )
    return n_tail


def _one_tail(
    scores: Array, n_tail: int, rate: float, significance: float, draw: np.random.Generator
) -> tuple[float, Array]:
    """Limit of a tail, and true rates of the limits of bootstrapped tails, shape (n_bootstrap,)."""
    ordered = np.sort(scores)
    start, tail = ordered[-n_tail - 1], ordered[-n_tail:]
    excesses = tail - start
    # The fit divides by the lower quartile, which is no smaller than the lowest fifth.
    if not np.all(np.isfinite(excesses)) or excesses[n_tail // 5] <= 0.0:
        raise NotStatedError(
            "the tail of the healthy scores is infinite or made of equal scores: no model fits"
        )
    model = fit_generalised_pareto(excesses)
    # How many scores lie in the tail is a matter of chance, too.
    counts = draw.binomial(scores.size, n_tail / scores.size, N_BOOTSTRAP)
    # 1 − random is never 0, at which the excess could be infinite.
    drawn = np.sort(model.excess(1.0 - draw.random((N_BOOTSTRAP, n_tail))), axis=-1)
    again = fit_generalised_pareto(drawn)
    beyond = np.mean(anderson_darling(again, drawn) >= anderson_darling(model, excesses))
    if beyond < significance:
        raise NotStatedError(
            f"the tail of the {scores.size} healthy scores is not generalised Pareto (Anderson–Darling, "
            f"p = {beyond:.3f}): no rate of {rate:.3g} can be stated"
        )
    share = n_tail / scores.size
    limit = float(start + model.excess(np.array([rate / share]))[0])
    # A rate above the share of the tail has its limit at the start of the tail.
    limits = again.excess(np.minimum(rate * scores.size / np.maximum(counts, 1), 1.0)[:, None])[:, 0]
    return limit, share * model.survival(limits)


ThresholdKind = Literal["quantile", "tolerance", "tail"]

THRESHOLDS: Mapping[ThresholdKind, Callable[..., Threshold]] = {
    "quantile": quantile_threshold,
    "tolerance": tolerance_threshold,
    "tail": tail_threshold,
}
"""Method that sets a threshold from healthy scores."""
