"""Profile likelihood of probability-of-detection curves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.likelihood import log_likelihood, maximise


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
