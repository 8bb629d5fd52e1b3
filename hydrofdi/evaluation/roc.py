"""Receiver operating characteristic, detection error trade-off and partial area."""

from __future__ import annotations

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
