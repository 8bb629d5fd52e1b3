"""Smallest detectable severity, by likelihood ratio."""

from __future__ import annotations

import numpy as np

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.pod.monotone import detected_level
from hydrofdi.evaluation.pod.profile import crossing, deficit, quantile_of_chi_square
from hydrofdi.evaluation.scores import share_between_0_and_1


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
