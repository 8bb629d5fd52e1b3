"""Likelihood-ratio bound of a probability-of-detection curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.likelihood import CERTAIN, log_cumulative
from hydrofdi.evaluation.pod.profile import crossing, deficit, quantile_of_chi_square
from hydrofdi.evaluation.scores import Array


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
    drop = quantile_of_chi_square(2.0 * confidence - 1.0)
    predictors = [_lower_predictor(curve, place, drop) for place in curve.axis.place(severity)]
    rise, floor = np.exp(log_cumulative(np.array(predictors), curve.link)), curve.false_alarm_rate
    return np.asarray(floor + (1.0 - floor) * rise)


def _lower_predictor(curve: PodCurve, place: float, drop: float) -> float:
    """Lower bound of the linear predictor at a place, searched with doubling steps from the fitted value."""

    def above(predictor: float) -> float:
        return deficit(curve, place, predictor) - drop

    start = float(np.clip(curve.intercept + curve.slope * place, -0.9 * CERTAIN, 0.9 * CERTAIN))
    step = 0.5
    while step < CERTAIN and above(start - step) < 0.0:
        step *= 2.0
    return crossing(above, start, float(np.clip(start - step, -CERTAIN, CERTAIN)))
