"""Changes of a number against healthy runs, compared with those of healthy replicates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

Array = NDArray[np.float64]

LEAST_SHARE = 0.01
"""A healthy value below this share of the largest size over all runs counts as near zero."""


@dataclass(frozen=True)
class Changes:
    """Changes of all runs against one kind of baseline; each of shape (n_run,), NaN if there is none.

    Attributes
    ----------
    absolute : ndarray
        In the unit of the number, above zero where it rose.
    percent : ndarray
        In percent of the size of the healthy value; NaN if that is near zero.
    low, high : ndarray
        Smallest and largest change of the healthy replicates of the baseline, in the unit of the number.
    """

    absolute: Array
    percent: Array
    low: Array
    high: Array

    @property
    def is_healthy(self) -> NDArray[np.bool_]:
        """Whether the change lies within those of the healthy replicates."""
        with np.errstate(invalid="ignore"):
            return np.asarray((self.absolute >= self.low) & (self.absolute <= self.high))


@dataclass(frozen=True)
class HealthySpread:
    """Spread of the healthy replicates of each run, shape (n_run,); NaN for runs without replicates.

    Attributes
    ----------
    mean : ndarray
        Mean of its replicates.
    low, high : ndarray
        Smallest and largest change of a replicate against the mean of the others, in the unit of the number.
    width : ndarray
        Largest minus smallest replicate; zero without replicates.
    count : ndarray of int
        Replicates with a number.
    """

    mean: Array
    low: Array
    high: Array
    width: Array
    count: NDArray[np.int64]


def relative_change(healthy: Array, values: Array, width: Array | float = 0.0) -> Array:
    """Change from a healthy value in percent of its size, above zero if the number rose.

    NaN if the healthy value is near zero: its size is below 1 % of the largest size over all runs, or
    below the width of its replicates.
    """
    largest = np.nanmax(np.abs(values), initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        known = np.abs(healthy) > np.maximum(LEAST_SHARE * largest, width)
        change: Array = np.where(known, 100.0 * (values - healthy) / np.abs(healthy), np.nan)
    return change


def healthy_spread(values: Array, data: ExperimentData) -> HealthySpread:
    """The spread of the replicates of each healthy run."""
    mean, low, high = (np.full(data.n_run, np.nan) for _ in range(3))
    width, count = np.zeros(data.n_run), np.zeros(data.n_run, dtype=np.int64)
    for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist():
        found = values[data.replicate_of == position]
        found = found[np.isfinite(found)]
        count[position] = len(found)
        if len(found) > 1:
            own = found - (found.sum() - found) / (len(found) - 1)
            mean[position], low[position], high[position] = found.mean(), own.min(), own.max()
            width[position] = np.ptp(found)
    return HealthySpread(mean, low, high, width, count)


def changes(
    values: Array, baseline: NDArray[np.int64], spread: HealthySpread, data: ExperimentData
) -> Changes:
    """Changes against the healthy run of each run, or the mean of its replicates if there are any.

    Parameters
    ----------
    values : ndarray, shape (n_run,)
    baseline : ndarray of int, shape (n_run,)
        Row of the healthy run.
    spread : HealthySpread
        Made from `values`.
    data : ExperimentData
    """
    healthy = spread.mean if data.has_replicates else values
    against = np.where(baseline == names.NO_BASELINE, np.nan, healthy[baseline])
    percent = relative_change(against, values, spread.width[baseline])
    return Changes(values - against, percent, spread.low[baseline], spread.high[baseline])
