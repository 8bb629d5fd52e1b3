"""The smallest detectable severity, and bounds of a curve, from the ratio of likelihoods."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.pod.likelihood import log_cumulative, log_likelihood, maximise
from hydrofdi.evaluation.pod.monotone import detected_level
from hydrofdi.evaluation.scores import Array, share_between_0_and_1

ENDS = (-36.0, 36.0)
"""Linear predictors at which a probability is 0 and 1 to the last digit."""


def smallest_detectable(
    curve: PodCurve, *, probability: float = 0.9, confidence: float | None = 0.95
) -> DetectableSeverity:
    """The severity that is detected with a probability: q90/95 unless asked otherwise.

    With a confidence, the largest severity q for which 2 (ln L_max - ln L(q)) ≤ χ²₁(2γ - 1), where L(q) is
    the largest likelihood of curves through POD(q) = p: Cheng and Iles, Technometrics 30 (1988) 309;
    MIL-HDBK-1823A (2009), appendix G. Where hits and misses are apart, it is a tested level (`monotone`).

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
    rise, first, last = curve.quantile_of_rise(probability), *np.log10(curve.tally.span)
    if rise == -np.inf:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    place = _where(curve, rise)
    if confidence is not None and place <= last:
        place = _upper(curve, rise, max(place, first), last, _drop(2.0 * confidence - 1.0))
    if place > last:
        return DetectableSeverity("above", curve.tally.span[1], probability, confidence)
    if place <= first:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    return DetectableSeverity("within", float(10.0**place), probability, confidence)


def curve_bounds(curve: PodCurve, severity: ArrayLike, *, confidence: float = 0.95) -> tuple[Array, Array]:
    """Two-sided bounds of the probability of detection at each severity, from the ratio of likelihoods.

    Where hits and misses are apart these are those of the fitted family, and too narrow.

    Parameters
    ----------
    curve : PodCurve
    severity : array_like, shape (n,)
    confidence : float

    Returns
    -------
    low, high : ndarray, shape (n,)
    """
    places = np.log10(np.asarray(severity, dtype=float))
    drop, floor = _drop(confidence), curve.false_alarm_rate
    ends = [
        [_crossing(_at(curve, place, drop), _middle(curve, place), end) for place in places] for end in ENDS
    ]
    low, high = (np.exp(log_cumulative(np.array(end), curve.link)) for end in ends)
    return floor + (1.0 - floor) * low, floor + (1.0 - floor) * high


def _at(curve: PodCurve, place: float, drop: float) -> Callable[[float], float]:
    return lambda rise: _deficit(curve, place, rise) - drop


def _middle(curve: PodCurve, place: float) -> float:
    return float(np.clip(curve.intercept + curve.slope * place, 0.9 * ENDS[0], 0.9 * ENDS[1]))


def _where(curve: PodCurve, rise: float) -> float:
    """lg of the severity at which the fitted predictor is `rise`; infinite where a flat curve has none."""
    if curve.slope:
        return (rise - curve.intercept) / curve.slope
    return -np.inf if curve.intercept >= rise else np.inf


def _upper(curve: PodCurve, rise: float, start: float, last: float, drop: float) -> float:
    """lg of the bound: `start` where it lies no higher, ∞ where it lies beyond the tested severities."""
    if _deficit(curve, last, rise) < drop:
        return np.inf
    if _deficit(curve, start, rise) >= drop:
        return start
    return _crossing(lambda place: _deficit(curve, place, rise) - drop, start, last)


def _deficit(curve: PodCurve, place: float, rise: float) -> float:
    """2 (ln L_max - ln L) of the best rising curve whose predictor at lg a = `place` is `rise`."""
    distance = np.log10(curve.tally.severity) - place
    offset = np.full_like(distance, rise)
    (slope,) = maximise(
        distance[:, None], offset, curve.tally, curve.false_alarm_rate, curve.link, curve.slope
    )
    predictor = offset + max(float(slope), 0.0) * distance
    return 2.0 * (
        curve.log_likelihood - log_likelihood(predictor, curve.tally, curve.false_alarm_rate, curve.link)
    )


def _drop(confidence: float) -> float:
    """Quantile of χ² with one degree of freedom."""
    from scipy.special import chdtri

    return float(chdtri(1.0, 1.0 - confidence))


def _crossing(function: Callable[[float], float], start: float, end: float) -> float:
    """Where a function that is negative at `start` becomes zero; `end` where it does not."""
    from scipy.optimize import brentq

    if function(end) < 0.0:
        return end
    return float(brentq(function, start, end, xtol=1e-7)) if function(start) < 0.0 else start
