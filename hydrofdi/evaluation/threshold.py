"""Thresholds of scores from healthy records."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.scores import Array, measurable, share_between_0_and_1


def records_needed(false_alarm_rate: float, confidence: float, rank: int = 1) -> int:
    """Smallest n for which the `rank`-th largest of n scores is a tolerance limit.

    Parameters
    ----------
    false_alarm_rate, confidence : float
    rank : int
        Rank, at least 1.
    """
    below, enough = rank - 1, 2 * rank
    while _confidence_at(rank, enough, false_alarm_rate) < confidence:
        below, enough = enough, 2 * enough
    while enough - below > 1:
        middle = (below + enough) // 2
        if _confidence_at(rank, middle, false_alarm_rate) < confidence:
            below = middle
        else:
            enough = middle
    return enough


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
    direction : Direction

    Raises
    ------
    NotStatedError
        There are too few records; the message states how many are needed.
    """
    from scipy.special import betaincinv

    share_between_0_and_1("the false-alarm rate", false_alarm_rate)
    share_between_0_and_1("the confidence", confidence)
    known, missing = measurable(healthy)
    sides = direction.n_side
    rank = _largest_rank(known.size, false_alarm_rate, confidence) // sides * sides
    if not rank:
        needed = records_needed(false_alarm_rate, confidence, sides)
        raise NotStatedError(
            f"a false-alarm rate of at most {100.0 * false_alarm_rate:.3g} % with {100.0 * confidence:.4g} %"
            f" confidence needs {needed} healthy records, not {known.size}",
            needed,
        )
    bound = float(betaincinv(rank, known.size + 1 - rank, confidence))
    limits = limits_at_rank(np.sort(known), rank, direction)
    return Threshold(
        *limits, false_alarm_rate, (0.0, bound), confidence, known.size, missing, "tolerance limit"
    )


def _confidence_at(rank: int, n: int, false_alarm_rate: float) -> float:
    from scipy.special import betainc

    return float(betainc(rank, n + 1 - rank, false_alarm_rate))


def _largest_rank(n: int, false_alarm_rate: float, confidence: float) -> int:
    """Largest rank that meets the confidence; 0 if none does."""
    keeps, fails = 0, n + 1
    while fails - keeps > 1:
        middle = (keeps + fails) // 2
        if _confidence_at(middle, n, false_alarm_rate) >= confidence:
            keeps = middle
        else:
            fails = middle
    return keeps


@dataclass(frozen=True)
class Threshold:
    """Limits beyond which a score raises an alarm.

    Attributes
    ----------
    low, high : float
        Scores below `low` or above `high` raise an alarm, scores on a limit do not; infinite if the direction
        has no such limit.
    false_alarm_rate : float
        Design false-alarm rate.
    interval : tuple of float
        Interval of the true rate, at level `confidence`.
    confidence : float
    n_healthy : int
        Number of healthy records used.
    not_measurable : int
        Number of further healthy records without a score.
    method : str
        ``quantile``, ``tolerance limit`` or ``tail model``.
    """

    low: float
    high: float
    false_alarm_rate: float
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
    direction : Direction
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

    Raises
    ------
    NotStatedError
        There are too few records: α (n + 1) is less than 1, or less than 2 for both directions.
    """
    from scipy.special import betaincinv

    share_between_0_and_1("the false-alarm rate", false_alarm_rate)
    known, missing = measurable(healthy)
    sides = direction.n_side
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
    return Threshold(
        *limits, false_alarm_rate, (float(low), float(high)), confidence, known.size, missing, "quantile"
    )
