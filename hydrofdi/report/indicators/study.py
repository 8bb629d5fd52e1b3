"""Values of each indicator over an experiment, and their changes against healthy runs and replicates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.axes import Axis, Group, swept_runs, varied_axes
from hydrofdi.report.indicators.measured import MeasuredIndicator, MeasuredOutput, measured_indicators
from hydrofdi.report.intervals import span_of
from hydrofdi.report.runs import table_runs
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

Array = NDArray[np.float64]

Range = tuple[float, float]
"""Smallest and largest of some numbers; NaN if there is none."""

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


@dataclass(frozen=True)
class Change:
    """Changes of the runs of a group against one kind of baseline.

    Attributes
    ----------
    percent : tuple of float
        Their range [%]; NaN if the healthy value of a run is near zero.
    absolute : tuple of float
        The same in the unit of the output.
    is_healthy : bool
        Whether all of them lie within those of healthy replicates.
    """

    percent: Range
    absolute: Range
    is_healthy: bool


@dataclass(frozen=True)
class GroupChange:
    """Values of the `n_run` runs of a group that have a number, and their changes against each baseline."""

    group: Group
    n_run: int
    values: Range
    against: Mapping[str, Change]


@dataclass(frozen=True)
class OutputStudy:
    """An output over an experiment.

    Attributes
    ----------
    measured : MeasuredOutput
    healthy : tuple of float
        Range of its values in the fixed baselines; of the mean of their replicates if there are any.
    spread : tuple of float
        Range of the changes of the replicates of the fixed baselines, each against the mean of the others,
        in the unit of the output.
    replicates : HealthySpread
        Of each healthy run.
    n_healthy : int
        Number of fixed baselines, or of their replicates, that have a number.
    n_run : int
        Runs that have a number.
    against : mapping of str to Changes
        ``fixed`` and ``matched`` → changes of all runs.
    over : dict of str to tuple of GroupChange
        Axis → changes of its groups.
    """

    measured: MeasuredOutput
    healthy: Range
    spread: Range
    replicates: HealthySpread
    n_healthy: int
    n_run: int
    against: Mapping[str, Changes]
    over: dict[str, tuple[GroupChange, ...]]


@dataclass(frozen=True)
class IndicatorStudy:
    """An indicator over an experiment.

    Attributes
    ----------
    measured : MeasuredIndicator
    outputs : tuple of OutputStudy
    axes : tuple of Axis
        Axes over which any output differs.
    idle_axes : tuple of Axis
        The others.
    n_run : int
        Runs of the table, without replicates.
    unmeasured : dict of int to str
        Row of a run without any number → why.
    has_replicates : bool
        Whether there are healthy replicates.
    """

    measured: MeasuredIndicator
    outputs: tuple[OutputStudy, ...]
    axes: tuple[Axis, ...]
    idle_axes: tuple[Axis, ...]
    n_run: int
    unmeasured: dict[int, str]
    has_replicates: bool

    @property
    def varies(self) -> bool:
        """Whether any output differs between the runs of the table."""
        spans = (span_of(output.measured.means) for output in self.outputs)
        return any(low < high for low, high in spans)


def study_indicators(data: ExperimentData) -> tuple[IndicatorStudy, ...]:
    """All indicators of an experiment except that of the details."""
    found = measured_indicators(data)
    kept, axes = table_runs(data), varied_axes(data, swept_runs(data)) if found else ()
    return tuple(study_indicator(measured, data, kept, axes) for measured in found)


def study_indicator(
    measured: MeasuredIndicator, data: ExperimentData, kept: NDArray[np.bool_], axes: tuple[Axis, ...]
) -> IndicatorStudy:
    """One indicator over the runs that are kept."""
    touching = tuple(axis for axis in axes if any(_differs(output, axis) for output in measured.outputs))
    return IndicatorStudy(
        measured=measured,
        outputs=tuple(_study_output(output, data, kept, touching) for output in measured.outputs),
        axes=touching,
        idle_axes=tuple(axis for axis in axes if all(axis is not other for other in touching)),
        n_run=int(kept.sum()),
        unmeasured=_unmeasured(measured, data, kept),
        has_replicates=data.has_replicates,
    )


def _differs(output: MeasuredOutput, axis: Axis) -> bool:
    """Whether an output has other numbers in one group of an axis than in another."""
    first, *others = (np.sort(output.means[group.rows]) for group in axis.groups)
    return not all(np.array_equal(first, other, equal_nan=True) for other in others)


def _study_output(
    measured: MeasuredOutput, data: ExperimentData, kept: NDArray[np.bool_], axes: tuple[Axis, ...]
) -> OutputStudy:
    values, spread = measured.means, healthy_spread(measured.means, data)
    rows = {"fixed": data.fixed_baseline, "matched": data.matched_baseline}
    against = {name: changes(values, baseline, spread, data) for name, baseline in rows.items()}
    baselines = np.unique(data.fixed_baseline[kept & (data.fixed_baseline != names.NO_BASELINE)])
    healthy = spread.mean if data.has_replicates else values
    sources = np.isin(data.replicate_of, baselines) if data.has_replicates else baselines
    return OutputStudy(
        measured=measured,
        healthy=span_of(healthy[baselines]),
        spread=span_of([*spread.low[baselines], *spread.high[baselines]]),
        replicates=spread,
        n_healthy=int(np.isfinite(values[sources]).sum()),
        n_run=int(np.isfinite(values[kept]).sum()),
        against=against,
        over={axis.name: tuple(_group_change(group, values, against) for group in axis.groups)
              for axis in axes},
    )  # fmt: skip


def _group_change(group: Group, values: Array, against: Mapping[str, Changes]) -> GroupChange:
    rows = group.rows & np.isfinite(values)
    changed = {name: _change(own, rows & np.isfinite(own.absolute)) for name, own in against.items()}
    return GroupChange(group, int(rows.sum()), span_of(values[rows]), changed)


def _change(changes: Changes, rows: NDArray[np.bool_]) -> Change:
    """In percent if every change has a percentage."""
    percent = changes.percent[rows]
    return Change(
        span_of(percent if np.isfinite(percent).all() else []),
        span_of(changes.absolute[rows]),
        bool(rows.any() and changes.is_healthy[rows].all()),
    )


def _unmeasured(measured: MeasuredIndicator, data: ExperimentData, kept: NDArray[np.bool_]) -> dict[int, str]:
    """Reasons why runs have no number: how they ended, or what is missing in their records."""
    reasons = {}
    for row in np.flatnonzero(kept & ~measured.has_number).tolist():
        status = str(data.columns[names.STATUS][row])
        reasons[row] = measured.obstacle(row) if status == "ok" else status
    return reasons
