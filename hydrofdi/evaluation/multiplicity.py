"""Corrections for multiple comparisons of indicators."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True, eq=False)
class ManyTests:
    """P-values of several tests, corrected for multiplicity.

    Attributes
    ----------
    n_tried : int
        Number of all tests tried, including those not reported.
    p_values : ndarray, shape (n_test,)
        Corrected p-values, in the order given.
    """

    n_tried: int
    p_values: Array


def holm(p_values: ArrayLike, *, n_tried: int | None = None) -> ManyTests:
    """P-values adjusted by Holm's method: the family-wise error rate is at most α under any dependence.

    Holm, Scandinavian Journal of Statistics 6 (1979) 65.

    Parameters
    ----------
    p_values : array_like, shape (n_test,)
        NaN if a test is undefined; it still counts as tried.
    n_tried : int, optional
        Number of tests tried; larger than the number of p-values if only the best are given.

    Raises
    ------
    ValueError
        There are more p-values than tests tried.
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
