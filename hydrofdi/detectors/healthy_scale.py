"""Standardisation of scores by healthy median and spread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.detectors.scores.contract import LEAST_RECORDS
from hydrofdi.detectors.scores.features import standardisation
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable


@dataclass(frozen=True)
class HealthyScale:
    """z = (x − centre)/spread.

    Attributes
    ----------
    centre : float
        Median of the healthy scores.
    spread : float
        Their interquartile range over 1.349; the standard deviation if the quartiles are equal.
    n : int
        Number of healthy scores.
    """

    centre: float
    spread: float
    n: int

    def __call__(self, scores: ArrayLike) -> Array:
        """Standardised scores, of the same shape."""
        return np.asarray((np.asarray(scores, dtype=float) - self.centre) / self.spread)


def healthy_scale(scores: ArrayLike) -> HealthyScale:
    """Fit the scale to healthy scores of many instants or records; NaN values are ignored.

    Parameters
    ----------
    scores : array_like
        Any shape.

    Raises
    ------
    NotStatedError
        There are fewer than five scores, or all are equal.
    """
    known, _ = measurable(np.ravel(scores))
    known = known[np.isfinite(known)]
    if known.size < LEAST_RECORDS:
        raise NotStatedError(
            f"a healthy scale needs {LEAST_RECORDS} healthy scores, not {known.size}", LEAST_RECORDS
        )
    scale = standardisation(known[:, None])
    return HealthyScale(float(scale.centre[0]), float(scale.scale[0]), known.size)
