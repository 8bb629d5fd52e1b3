"""The direction in which a score departs from health."""

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.auc import area_under_curve
from hydrofdi.evaluation.scores import Array


class Direction(StrEnum):
    """Which departures raise an alarm. Fixed before any test record is looked at."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"

    @property
    def n_side(self) -> int:
        """Number of limits that a threshold has."""
        return 2 if self is Direction.BOTH else 1


def suspicion(scores: ArrayLike, direction: Direction, centre: float = 0.0) -> Array:
    """Scores of which the larger is the more suspicious, as a ROC curve needs them.

    Parameters
    ----------
    scores : array_like, shape (n_record,)
    direction : Direction
    centre : float
        The healthy value from which both directions depart, such as the median of the fit records.
    """
    values = np.asarray(scores, dtype=float)
    if direction is Direction.BOTH:
        if not np.isfinite(centre):
            raise ValueError("the healthy value is not finite")
        return np.abs(values - centre)
    return values if direction is Direction.RISING else -values


def learned_direction(healthy: ArrayLike, faulty: ArrayLike, *, confidence: float = 0.95) -> Direction:
    """The direction that fit records show; both if they do not decide it.

    Healthy records alone hold no direction: it takes faulty ones, and none of them may be tested afterwards.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
        Scores of fit records.
    confidence : float
        Of the interval of the area under the ROC curve that has to leave out 1/2.
    """
    area = area_under_curve(healthy, faulty, confidence=confidence)
    if area.low > 0.5:
        return Direction.RISING
    return Direction.FALLING if area.high < 0.5 else Direction.BOTH
