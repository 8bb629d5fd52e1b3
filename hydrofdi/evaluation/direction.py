"""Direction in which a score changes with a fault."""

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.roc import area_under_curve
from hydrofdi.evaluation.scores import Array


class Direction(StrEnum):
    """Direction of change that raises an alarm; it is fixed before any test record is used."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"

    @property
    def n_side(self) -> int:
        """Number of limits of a threshold."""
        return 2 if self is Direction.BOTH else 1


def suspicion(scores: ArrayLike, direction: Direction, centre: float = 0.0) -> Array:
    """Transform scores so that larger values are more suspicious, as ROC curves require.

    Parameters
    ----------
    scores : array_like, shape (n_record,)
    direction : Direction
    centre : float
        Healthy reference value for both directions, such as the median of the fit records.
    """
    values = np.asarray(scores, dtype=float)
    if direction is Direction.BOTH:
        if not np.isfinite(centre):
            raise ValueError("the healthy reference value is not finite")
        return np.abs(values - centre)
    return values if direction is Direction.RISING else -values


def learned_direction(healthy: ArrayLike, faulty: ArrayLike, *, confidence: float = 0.95) -> Direction:
    """Direction learned from fit records; both if it is not significant.

    This requires faulty fit records, which must not be used for testing afterwards.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
        Scores of fit records.
    confidence : float
        Confidence level of the interval of the area under the ROC curve, which must exclude 1/2.
    """
    area = area_under_curve(healthy, faulty, confidence=confidence)
    if area.low > 0.5:
        return Direction.RISING
    return Direction.FALLING if area.high < 0.5 else Direction.BOTH
