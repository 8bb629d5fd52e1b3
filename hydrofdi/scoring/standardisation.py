"""Robust standardisation of features, fitted only to fit records."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array

NORMAL_QUARTILES = 1.3489795003921634
"""Interquartile range of a normal distribution, in standard deviations."""

FAR = 5.0
"""Standardised values of fit records are limited to ± this value, so that outliers do not dominate a fit."""


@dataclass(frozen=True, eq=False)
class Standardisation:
    """z = (x - median)/(interquartile range/1.349); the standard deviation if the quartiles are equal.

    Attributes
    ----------
    kept : ndarray of int, shape (n_kept,)
        Features that vary among the fit records. Constant features have no scale and are omitted.
    centre, scale : ndarray, shape (n_kept,)
    """

    kept: NDArray[np.intp]
    centre: Array
    scale: Array

    def __call__(self, values: Array) -> Array:
        """Standardised features, shape (n_record, n_kept)."""
        return np.ascontiguousarray((values[:, self.kept] - self.centre) / self.scale)

    def held(self, values: Array) -> Array:
        """Standardised features of fit records, limited to ±5."""
        return np.clip(self(values), -FAR, FAR)


def standardisation(values: Array) -> Standardisation:
    """Fit the standardisation to fit records.

    Parameters
    ----------
    values : ndarray, shape (n_fit, n_feature)

    Raises
    ------
    NotStatedError
        No feature varies.
    """
    low, centre, high = np.quantile(values, [0.25, 0.5, 0.75], axis=0)
    quartiles = (high - low) / NORMAL_QUARTILES
    rounding = 1e-12 * np.abs(values).max(axis=0)
    scale = np.where(quartiles > rounding, quartiles, values.std(axis=0))
    (kept,) = np.nonzero(scale > rounding)
    if not kept.size:
        raise NotStatedError("no feature varies among the fit records")
    return Standardisation(kept, centre[kept], scale[kept])
