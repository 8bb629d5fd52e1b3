"""Multiple comparisons: what the best of many indicators is worth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True, eq=False)
class ManyTests:
    """P-values of several tests, corrected for their number.

    Attributes
    ----------
    n_tried : int
        All that were tried, those that were not reported included.
    p_values : ndarray, shape (n_test,)
        Corrected, in the order given.
    """

    n_tried: int
    p_values: Array


def holm(p_values: ArrayLike, *, n_tried: int | None = None) -> ManyTests:
    """P-values of which the chance that any false one is below α is at most α, whatever their dependence.

    Holm, Scandinavian Journal of Statistics 6 (1979) 65.

    Parameters
    ----------
    p_values : array_like, shape (n_test,)
        NaN if a test could not tell; it counts as tried.
    n_tried : int, optional
        Larger than their number where only the best are given.

    Raises
    ------
    ValueError
        More p-values are given than were tried.
    """
    values = np.asarray(p_values, dtype=float)
    tried = values.size if n_tried is None else n_tried
    if tried < values.size:
        raise ValueError(f"{values.size} p-values of {tried} tests")
    order = np.argsort(values)
    corrected = np.empty(values.size)
    corrected[order] = np.maximum.accumulate(values[order] * (tried - np.arange(values.size)))
    return ManyTests(tried, np.minimum(corrected, 1.0))


def simultaneous_confidence(confidence: float, n_tried: int) -> float:
    """The confidence of each interval for which all of them hold together: Bonferroni's, 1 - (1 - γ)/n.

    Dunn, Journal of the American Statistical Association 56 (1961) 52. The q90/95 of the best of n indicators
    is one only at this confidence.

    Parameters
    ----------
    confidence : float
        γ, of all together.
    n_tried : int
        All indicators that were looked at.
    """
    return 1.0 - (1.0 - confidence) / n_tried


def confidence_text(confidence: float) -> str:
    """A confidence in percent, with two digits of what is left to 100: 95, 99.29, 99.9988."""
    rest = 100.0 * (1.0 - confidence)
    digits = max(1 - math.floor(math.log10(rest)), 0) if rest > 0.0 else 0
    return f"{round(100.0 * confidence, digits):.10g}"
