"""Comparison of two detectors on the same records."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.auc import placements
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True)
class Difference:
    """Difference of two paired quantities, first minus second.

    Attributes
    ----------
    value, low, high : float
        Difference and its two-sided interval.
    p_value : float
        p-value of the null hypothesis of no difference; NaN if undefined.
    confidence : float
    n_record : int
        Number of records with both scores.
    not_measurable : int
        Number of further records that lack one or both scores.
    """

    value: float
    low: float
    high: float
    p_value: float
    confidence: float
    n_record: int
    not_measurable: int


def compare_areas(
    healthy: tuple[ArrayLike, ArrayLike], faulty: tuple[ArrayLike, ArrayLike], *, confidence: float = 0.95
) -> Difference:
    """Difference of two areas under ROC curves of the same records.

    DeLong, DeLong and Clarke-Pearson, Biometrics 44 (1988) 837.

    Parameters
    ----------
    healthy, faulty : tuple of array_like, each of shape (n_record,)
        Scores of the first and of the second detector, larger is more suspicious.
    confidence : float

    Raises
    ------
    NotStatedError
        Fewer than two records of one kind have both scores.
    """
    from scipy.special import ndtr, ndtri

    (below, n_missing), (above, n_lost) = _both(*healthy), _both(*faulty)
    if min(below.shape[1], above.shape[1]) < 2:
        raise NotStatedError("the comparison of two areas needs two records of each kind with both scores")
    pairs = [placements(mine, theirs) for mine, theirs in zip(below, above, strict=True)]
    of_healthy, of_faulty = (first - second for first, second in zip(*pairs, strict=True))
    deviation = math.sqrt(of_healthy.var(ddof=1) / of_healthy.size + of_faulty.var(ddof=1) / of_faulty.size)
    value = float(of_faulty.mean())
    spread = float(ndtri((1.0 + confidence) / 2.0)) * deviation
    p_value = 2.0 * float(ndtr(-abs(value) / deviation)) if deviation > 0.0 else math.nan
    low, high = max(value - spread, -1.0), min(value + spread, 1.0)
    n_record = below.shape[1] + above.shape[1]
    return Difference(value, low, high, p_value, confidence, n_record, n_missing + n_lost)


def compare_alarms(first: ArrayLike, second: ArrayLike, *, confidence: float = 0.95) -> Difference:
    """Difference of two alarm rates on the same records.

    The p-value is that of McNemar's exact test: Psychometrika 12 (1947) 153. The interval is that of Tango's
    score test, Statistics in Medicine 17 (1998) 891.

    Parameters
    ----------
    first, second : array_like, shape (n_record,)
        1 for an alarm, 0 for none, NaN if not measurable.
    confidence : float

    Raises
    ------
    NotStatedError
        No record has both outcomes.
    """
    from scipy.special import bdtr

    (mine, theirs), missing = _both(first, second)
    if not mine.size:
        raise NotStatedError("no record has the outcomes of both detectors")
    more, fewer, n = int(np.sum(mine > theirs)), int(np.sum(mine < theirs)), mine.size
    p_value = min(1.0, 2.0 * float(bdtr(min(more, fewer), more + fewer, 0.5)))
    low, high = (
        -_upper_score_limit(fewer, more, n, confidence),
        _upper_score_limit(more, fewer, n, confidence),
    )
    return Difference((more - fewer) / n, low, high, p_value, confidence, n, missing)


def _upper_score_limit(more: int, fewer: int, n: int, confidence: float) -> float:
    """Largest difference that Tango's score test, with its constrained estimate, does not reject."""
    from scipy.optimize import brentq
    from scipy.special import ndtri

    z = float(ndtri((1.0 + confidence) / 2.0))

    def distance(difference: float) -> float:
        linear = (2.0 * n - more + fewer) * difference - more - fewer
        constant = fewer * difference * (1.0 - difference)
        share = (math.sqrt(linear**2 + 8.0 * n * constant) - linear) / (4.0 * n)
        variance = max(n * (2.0 * share + difference * (1.0 - difference)), 0.0)
        return more - fewer - n * difference + z * math.sqrt(variance)

    observed = (more - fewer) / n
    return float(brentq(distance, observed + 1e-12, 1.0)) if observed < 1.0 else 1.0


def _both(first: ArrayLike, second: ArrayLike) -> tuple[Array, int]:
    """Scores of the records that have both, shape (2, n_known), and the number of the other records."""
    scores = np.stack((np.asarray(first, dtype=float), np.asarray(second, dtype=float)))
    is_known = ~np.isnan(scores).any(axis=0)
    return scores[:, is_known], int((~is_known).sum())
