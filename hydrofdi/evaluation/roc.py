"""ROC curves and their areas."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable, share_between_0_and_1


@dataclass(frozen=True, eq=False)
class RocCurve:
    """Detection rate against false-alarm rate for all thresholds.

    Attributes
    ----------
    threshold : ndarray, shape (n_point,)
        Descending from ∞; scores at or above it are alarms.
    false_alarm_rate, detection_rate : ndarray, shape (n_point,)
        From (0, 0) to (1, 1).
    not_measurable : int
        Number of records without a score, which are excluded.
    """

    threshold: Array
    false_alarm_rate: Array
    detection_rate: Array
    not_measurable: int

    @property
    def miss_rate(self) -> Array:
        """1 - detection rate."""
        return 1.0 - self.detection_rate

    def partial_area(self, false_alarm_rate: float) -> float:
        """Partial area up to a false-alarm rate, scaled so that 0.5 is chance and 1 is perfect.

        McClish, Medical Decision Making 9 (1989) 190.

        Parameters
        ----------
        false_alarm_rate : float
            Largest false-alarm rate of the partial area.
        """
        share_between_0_and_1("the false-alarm rate", false_alarm_rate)
        inside = self.false_alarm_rate <= false_alarm_rate
        last = np.interp(false_alarm_rate, self.false_alarm_rate, self.detection_rate)
        rates = np.append(self.false_alarm_rate[inside], false_alarm_rate)
        area = float(np.trapezoid(np.append(self.detection_rate[inside], last), rates))
        chance = false_alarm_rate**2 / 2.0
        return 0.5 * (1.0 + (area - chance) / (false_alarm_rate - chance))


def roc_curve(healthy: ArrayLike, faulty: ArrayLike) -> RocCurve:
    """Empirical ROC curve; larger scores are more suspicious.

    Fawcett, Pattern Recognition Letters 27 (2006) 861: equal scores give one point, so that they count half
    in the area.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)

    Raises
    ------
    NotStatedError
        There is no healthy or no faulty score.
    """
    (below, n_missing), (above, n_lost) = measurable(healthy), measurable(faulty)
    if not below.size or not above.size:
        raise NotStatedError(f"a ROC curve needs scores of both kinds, not {below.size} and {above.size}")
    distinct = np.unique(np.concatenate((below, above)))[::-1]
    rates = [_share_at_or_above(scores, distinct) for scores in (below, above)]
    threshold = np.concatenate(([np.inf], distinct))
    return RocCurve(threshold, rates[0], rates[1], n_missing + n_lost)


def _share_at_or_above(scores: Array, thresholds: Array) -> Array:
    below = np.searchsorted(np.sort(scores), thresholds, "left")
    return np.concatenate(([0.0], 1.0 - below / scores.size))


@dataclass(frozen=True)
class Area:
    """Area under a ROC curve: the probability that a faulty record scores above a healthy one.

    Attributes
    ----------
    value, low, high : float
        Area and its two-sided interval.
    confidence : float
    n_healthy, n_faulty : int
    not_measurable : int
        Number of further records of both kinds without a score.
    """

    value: float
    low: float
    high: float
    confidence: float
    n_healthy: int
    n_faulty: int
    not_measurable: int


def placements(healthy: Array, faulty: Array) -> tuple[Array, Array]:
    """Fraction of faulty scores above each healthy one, and of healthy scores below each faulty one.

    Equal scores count half. These are the structural components of DeLong, DeLong and Clarke-Pearson,
    Biometrics 44 (1988) 837, computed from ranks in O(n log n) as in Sun and Xu, IEEE Signal Processing
    Letters 21 (2014) 1389.

    Parameters
    ----------
    healthy : ndarray, shape (n_healthy,)
    faulty : ndarray, shape (n_faulty,)
        Without NaN.
    """
    return 1.0 - share_below(faulty, healthy), share_below(healthy, faulty)


def share_below(scores: Array, of: Array) -> Array:
    """Fraction of `scores` below each score in `of`, equal ones counted half; shape of `of`."""
    ordered = np.sort(scores)
    twice = np.searchsorted(ordered, of, "left") + np.searchsorted(ordered, of, "right")
    return np.asarray(twice / (2.0 * scores.size))


def area_under_curve(healthy: ArrayLike, faulty: ArrayLike, *, confidence: float = 0.95) -> Area:
    """Area under the ROC curve of independent records; larger scores are more suspicious.

    The interval is DeLong's on the logit of the area. If its variance is undefined (perfect separation, a
    single record), it is method 5 of Newcombe, Statistics in Medicine 25 (2006) 559.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
    confidence : float

    Raises
    ------
    NotStatedError
        There is no healthy or no faulty score.
    """
    (below, n_missing), (above, n_lost) = measurable(healthy), measurable(faulty)
    if not below.size or not above.size:
        raise NotStatedError(f"a ROC curve needs scores of both kinds, not {below.size} and {above.size}")
    of_healthy, of_faulty = placements(below, above)
    value = float(of_faulty.mean())
    variance = _variance(of_healthy) + _variance(of_faulty)
    low, high = _interval(value, variance, below.size, above.size, confidence)
    return Area(value, low, high, confidence, below.size, above.size, n_missing + n_lost)


def _variance(components: Array) -> float:
    return float(components.var(ddof=1)) / components.size if components.size > 1 else math.nan


def _interval(value: float, variance: float, n: int, m: int, confidence: float) -> tuple[float, float]:
    from scipy.special import expit, logit, ndtri

    z = float(ndtri((1.0 + confidence) / 2.0))
    if variance > 0.0:
        spread = z * math.sqrt(variance) / (value * (1.0 - value))
        low, high = expit(logit(value) + np.array([-spread, spread]))
        return float(low), float(high)
    return _newcombe(value, n, m, z), 1.0 - _newcombe(1.0 - value, m, n, z)


def _newcombe(value: float, n: int, m: int, z: float) -> float:
    """Lower limit, at a distance of z standard deviations from `value`, under the exponential model."""
    from scipy.optimize import brentq

    def distance(area: float) -> float:
        pairs = (1.0 - area) / (2.0 - area) + area / (1.0 + area)
        variance = area * (1.0 - area) * (1.0 + ((n + m) / 2.0 - 1.0) * pairs) / (n * m)
        return value - area - z * math.sqrt(variance)

    return float(brentq(distance, 0.0, value - 1e-12)) if value > 1e-9 else 0.0
