"""The smallest detectable severity, from the ratio of likelihoods."""

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
    """The severity that is detected with a probability: q90/95 unless asked otherwise.

    With a confidence, the largest severity q for which 2 (ln L_max - ln L(q)) ≤ χ²₁(2γ - 1), where L(q) is
    the largest likelihood of curves through POD(q) = p: Venzon and Moolgavkar, Applied Statistics 37 (1988)
    87; MIL-HDBK-1823A (2009), appendix G. Where hits and misses are apart, it is a tested level
    (`monotone`).

    Parameters
    ----------
    curve : PodCurve
    probability : float
        p.
    confidence : float or None
        γ, from 0.5, that the severity is no larger; None for the estimate.

    Returns
    -------
    DetectableSeverity
        Within the tested severities, or on which side of them.
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
    """The place at which the fitted predictor is `rise`; infinite if a flat curve has none."""
    if curve.slope:
        return (rise - curve.intercept) / curve.slope
    return -np.inf if curve.intercept >= rise else np.inf


def _upper(curve: PodCurve, rise: float, start: float, last: float, drop: float) -> float:
    """The place of the bound: `start` if it is not higher, ∞ if it is beyond the tested ones."""
    if deficit(curve, last, rise) < drop:
        return np.inf
    if deficit(curve, start, rise) >= drop:
        return start
    return crossing(lambda place: deficit(curve, place, rise) - drop, start, last)
