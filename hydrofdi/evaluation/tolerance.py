"""Tolerance limits: thresholds with a bound on the false-alarm rate at a given confidence."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.scores import measurable, share_between_0_and_1
from hydrofdi.evaluation.threshold import Threshold, limits_at_rank


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
