"""Likelihood-ratio bounds of a probability-of-detection curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.likelihood import CERTAIN, log_cumulative
from hydrofdi.evaluation.pod.profile import crossing, deficit, quantile_of_chi_square
from hydrofdi.evaluation.scores import Array


def curve_bounds(curve: PodCurve, severity: ArrayLike, *, confidence: float = 0.95) -> tuple[Array, Array]:
    """Two-sided likelihood-ratio bounds of the probability of detection at each severity.

    If hits and misses are separated, the bounds are those of the fitted family, and too narrow.

    Parameters
    ----------
    curve : PodCurve
    severity : array_like, shape (n,)
    confidence : float

    Returns
    -------
    low, high : ndarray, shape (n,)
    """
    drop = quantile_of_chi_square(confidence)
    return _bound(curve, severity, drop, -1.0), _bound(curve, severity, drop, 1.0)


def lower_bound(curve: PodCurve, severity: ArrayLike, *, confidence: float = 0.95) -> Array:
    """One-sided lower bound of the probability of detection at each severity.

    It reaches p at the severity that `smallest_detectable` states for p with the same confidence.

    Parameters
    ----------
    curve : PodCurve
    severity : array_like, shape (n,)
    confidence : float
        From 0.5.

    Returns
    -------
    low : ndarray, shape (n,)
    """
    return _bound(curve, severity, quantile_of_chi_square(2.0 * confidence - 1.0), -1.0)


def _bound(curve: PodCurve, severity: ArrayLike, drop: float, side: float) -> Array:
    predictors = [_predictor_bound(curve, place, drop, side) for place in curve.axis.place(severity)]
    rise, floor = np.exp(log_cumulative(np.array(predictors), curve.link)), curve.false_alarm_rate
    return np.asarray(floor + (1.0 - floor) * rise)


def _predictor_bound(curve: PodCurve, place: float, drop: float, side: float) -> float:
    """Bound of the linear predictor at a place, searched with doubling steps from the fitted value."""

    def above(predictor: float) -> float:
        return deficit(curve, place, predictor) - drop

    start = float(np.clip(curve.intercept + curve.slope * place, -0.9 * CERTAIN, 0.9 * CERTAIN))
    step = 0.5
    while step < CERTAIN and above(start + side * step) < 0.0:
        step *= 2.0
    return crossing(above, start, float(np.clip(start + side * step, -CERTAIN, CERTAIN)))
