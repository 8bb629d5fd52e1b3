"""Smallest detectable severities: from curves of detection."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.pod.curve import CERTAIN, PodCurve, log_cumulative, log_likelihood, maximise
from hydrofdi.evaluation.pod.tally import DetectableSeverity, detected_level
from hydrofdi.evaluation.scores import Array, share_between_0_and_1


def deficit(curve: PodCurve, place: float, rise: float) -> float:
    """2 (ln L_max - ln L) of the best increasing curve whose predictor at `place` on the axis is `rise`."""
    distance = curve.axis.place(curve.tally.severity) - place
    offset = np.full_like(distance, rise)
    (slope,) = maximise(
        distance[:, None], offset, curve.tally, curve.false_alarm_rate, curve.link, curve.slope
    )
    predictor = offset + max(float(slope), 0.0) * distance
    return 2.0 * (
        curve.log_likelihood - log_likelihood(predictor, curve.tally, curve.false_alarm_rate, curve.link)
    )


def quantile_of_chi_square(confidence: float) -> float:
    """Quantile of χ² with one degree of freedom."""
    from scipy.special import chdtri

    return float(chdtri(1.0, 1.0 - confidence))


def crossing(function: Callable[[float], float], start: float, end: float) -> float:
    """Zero of a function that is negative at `start`; `end` if there is none."""
    from scipy.optimize import brentq

    if function(end) < 0.0:
        return end
    return float(brentq(function, start, end, xtol=1e-7)) if function(start) < 0.0 else start


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


def smallest_detectable(
    curve: PodCurve, *, probability: float = 0.9, confidence: float | None = 0.95
) -> DetectableSeverity:
    """Severity that is detected with a given probability and confidence; by default q90/95.

    With a confidence, it is the largest severity q for which 2 (ln L_max - ln L(q)) ≤ χ²₁(2γ - 1), where L(q)
    is the maximum likelihood of curves with POD(q) = p: Venzon and Moolgavkar, Applied Statistics 37 (1988)
    87; MIL-HDBK-1823A (2009), appendix G. If hits and misses are separated, it is a tested level
    (`monotone`).

    Parameters
    ----------
    curve : PodCurve
    probability : float
        p.
    confidence : float or None
        Confidence γ ≥ 0.5 that the severity is not larger; None for the estimate.

    Returns
    -------
    DetectableSeverity
        Severity within the tested ones, or the side on which it lies.
    """
    share_between_0_and_1("the probability", probability)
    if curve.is_step:
        return detected_level(curve.tally, probability=probability, confidence=confidence)
    rise, first, last = curve.quantile_of_rise(probability), *curve.axis.place(curve.tally.span)
    if rise == -np.inf:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    place = _where(curve, rise)
    if confidence is not None and place <= last:
        place = _upper(curve, rise, max(place, first), last, quantile_of_chi_square(2.0 * confidence - 1.0))
    if place > last:
        return DetectableSeverity("above", curve.tally.span[1], probability, confidence)
    if place <= first:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    return DetectableSeverity("within", curve.axis.severity(float(place)), probability, confidence)


def _where(curve: PodCurve, rise: float) -> float:
    """Place at which the fitted predictor is `rise`; infinite if the curve is flat."""
    if curve.slope:
        return (rise - curve.intercept) / curve.slope
    return -np.inf if curve.intercept >= rise else np.inf


def _upper(curve: PodCurve, rise: float, start: float, last: float, drop: float) -> float:
    """Place of the bound: at least `start`, ∞ if it exceeds the tested severities."""
    if deficit(curve, last, rise) < drop:
        return np.inf
    if deficit(curve, start, rise) >= drop:
        return start
    return crossing(lambda place: deficit(curve, place, rise) - drop, start, last)
