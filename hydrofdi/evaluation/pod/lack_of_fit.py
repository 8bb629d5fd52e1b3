"""Goodness of fit of probability-of-detection curves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.scores import Array

MOST_CELLS = 10

SMALLEST_EXPECTED = 2.0
"""Minimum expected number of hits and of misses per cell."""


@dataclass(frozen=True)
class LackOfFit:
    """Pearson's X² statistic of a curve.

    Attributes
    ----------
    statistic : float
    degrees : int
        Degrees of freedom: number of cells minus two.
    p_value : float
        NaN if there are too few cells.
    """

    statistic: float
    degrees: int
    p_value: float


def lack_of_fit(curve: PodCurve) -> LackOfFit:
    """Pearson's test over cells of adjacent severities with at least two expected hits and misses.

    Hosmer and Lemeshow, Communications in Statistics A 9 (1980) 1043; Cochran, Biometrics 10 (1954) 417, on
    the minimum expected count. A small p-value means that the quantiles of the curve must not be used.

    Parameters
    ----------
    curve : PodCurve
    """
    from scipy.special import chdtrc

    counted = curve.tally
    expected = counted.total * curve.probability(counted.severity)
    cells = _cells(expected, counted.total)
    hits, expects, total = (np.bincount(cells, values) for values in (counted.hits, expected, counted.total))
    degrees = hits.size - 2
    if degrees < 1:
        return LackOfFit(math.nan, max(degrees, 0), math.nan)
    statistic = float(np.sum((hits - expects) ** 2 * total / (expects * (total - expects))))
    return LackOfFit(statistic, degrees, float(chdtrc(degrees, statistic)))


def _cells(expected: Array, total: Array) -> np.ndarray:
    """Cell of each level, shape (n_level,), formed from below; the remainder joins the last cell."""
    size = total.sum() / MOST_CELLS if total.size > MOST_CELLS else 0.0
    cells, cell, hits, misses = np.empty(total.size, dtype=int), 0, 0.0, 0.0
    for place in range(total.size):
        cells[place] = cell
        hits, misses = hits + expected[place], misses + total[place] - expected[place]
        if min(hits, misses) >= SMALLEST_EXPECTED and hits + misses >= size:
            cell, hits, misses = cell + 1, 0.0, 0.0
    return np.minimum(cells, max(cell - 1, 0))
