"""Relative changes of a number, beside those of healthy replicates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.runs.changes import ROUNDING
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Changes:
    """Changes of all runs against one kind of baseline.

    Attributes
    ----------
    percent : ndarray, shape (n_run,)
        Above zero where the number rose; NaN where there is none, or its healthy value is zero.
    is_healthy : ndarray of bool, shape (n_run,)
        Whether the change lies within those of the healthy replicates of the baseline.
    """

    percent: Array
    is_healthy: NDArray[np.bool_]


@dataclass(frozen=True)
class HealthySpread:
    """What healthy actuators differ by: of each run that has replicates, else NaN; each of shape (n_run,).

    Attributes
    ----------
    mean : ndarray
        Mean of its replicates.
    low, high : ndarray
        Least and largest change of a replicate against the mean of the others [%].
    """

    mean: Array
    low: Array
    high: Array


def relative_change(healthy: Array, values: Array) -> Array:
    """Change from a healthy value in percent of its size, above zero where the number rose."""
    largest = np.nanmax(np.abs(values), initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        known = np.abs(healthy) > ROUNDING * largest
        change: Array = np.where(known, 100.0 * (values - healthy) / np.abs(healthy), np.nan)
    return change


def healthy_spread(values: Array, data: ExperimentData) -> HealthySpread:
    """The spread of the replicates of each healthy run."""
    mean, low, high = (np.full(data.n_run, np.nan) for _ in range(3))
    for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist():
        found = values[data.replicate_of == position]
        found = found[np.isfinite(found)]
        if len(found) > 1:
            of_others = (found.sum() - found) / (len(found) - 1)
            own = relative_change(of_others, found)
            mean[position], low[position], high[position] = found.mean(), own.min(), own.max()
    return HealthySpread(mean, low, high)


def changes(
    values: Array, baseline: NDArray[np.int64], spread: HealthySpread, data: ExperimentData
) -> Changes:
    """Changes against the healthy run of each run, or the mean of its replicates where there are any.

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
    percent = relative_change(np.where(baseline == names.NO_BASELINE, np.nan, healthy[baseline]), values)
    with np.errstate(invalid="ignore"):
        is_healthy = (percent >= spread.low[baseline]) & (percent <= spread.high[baseline])
    return Changes(percent, is_healthy)
