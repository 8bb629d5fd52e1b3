"""Corrections for multiple comparisons of indicators."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.scores import Array


def holm(p_values: ArrayLike) -> Array:
    """P-values adjusted by Holm's method: the family-wise error rate is at most α under any dependence.

    Holm, Scandinavian Journal of Statistics 6 (1979) 65.

    Parameters
    ----------
    p_values : array_like, shape (n_test,)
        NaN if a test is undefined; it still counts as tried.
    """
    values = np.asarray(p_values, dtype=float)
    order = np.argsort(values)
    corrected = np.empty(values.size)
    corrected[order] = np.maximum.accumulate(values[order] * (values.size - np.arange(values.size)))
    return np.minimum(corrected, 1.0)


def simultaneous_confidence(confidence: float, n_tried: int) -> float:
    """Confidence level per interval for a simultaneous level γ, by Bonferroni: 1 - (1 - γ)/n.

    Dunn, Journal of the American Statistical Association 56 (1961) 52. The bound of the best of n indicators
    is a valid q90/95 only at this level.

    Parameters
    ----------
    confidence : float
        Simultaneous level γ.
    n_tried : int
        Number of all indicators compared.
    """
    return 1.0 - (1.0 - confidence) / n_tried


def confidence_text(confidence: float) -> str:
    """A confidence level in percent, with two digits of its difference from 100: 95, 99.29, 99.9988."""
    rest = 100.0 * (1.0 - confidence)
    digits = max(1 - math.floor(math.log10(rest)), 0) if rest > 0.0 else 0
    return f"{round(100.0 * confidence, digits):.10g}"
