"""Values and changes of each indicator over an experiment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.axes import Axis, Group, swept_runs, varied_axes
from hydrofdi.report.indicators.changes import Changes, HealthySpread, changes, healthy_spread
from hydrofdi.report.indicators.measured import (
    MeasuredIndicator,
    MeasuredOutput,
    measured_indicators,
)
from hydrofdi.report.ranges import Range, range_of
from hydrofdi.report.runs import table_runs
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names


@dataclass(frozen=True)
class GroupChange:
    """Changes of the runs of a group.

    Attributes
    ----------
    group : Group
    n_run : int
        Runs of the group that have a number.
    values : Range
        Their numbers, in the unit of the output.
    fixed, matched : Range
        Changes against either baseline [%]; NaN if the healthy value of a run is near zero.
    fixed_absolute, matched_absolute : Range
        The same in the unit of the output.
    fixed_is_healthy, matched_is_healthy : bool
        Whether all of them lie within those of healthy replicates.
    """

    group: Group
    n_run: int
    values: Range
    fixed: Range
    matched: Range
    fixed_absolute: Range
    matched_absolute: Range
    fixed_is_healthy: bool
    matched_is_healthy: bool


@dataclass(frozen=True)
class OutputStudy:
    """An output over an experiment.

    Attributes
    ----------
    measured : MeasuredOutput
    healthy : Range
        Its values in the fixed baselines; the mean of their replicates if there are any.
    spread : Range
        Changes of the replicates of the fixed baselines, each against the mean of the others, in the unit of
        the output.
    replicates : HealthySpread
        Of each healthy run.
    n_healthy : int
        Number of fixed baselines, or of their replicates, that have a number.
    n_run : int
        Runs that have a number.
    fixed, matched : Changes
        Of all runs.
    over : dict of str to tuple of GroupChange
        Axis → changes of its groups.
    """

    measured: MeasuredOutput
    healthy: Range
    spread: Range
    replicates: HealthySpread
    n_healthy: int
    n_run: int
    fixed: Changes
    matched: Changes
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
        spans = (range_of(output.measured.means.tolist()) for output in self.outputs)
        return any(span.low < span.high for span in spans)


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
    fixed = changes(values, data.fixed_baseline, spread, data)
    matched = changes(values, data.matched_baseline, spread, data)
    baselines = np.unique(data.fixed_baseline[kept & (data.fixed_baseline != names.NO_BASELINE)])
    healthy = spread.mean if data.has_replicates else values
    sources = np.isin(data.replicate_of, baselines) if data.has_replicates else baselines
    return OutputStudy(
        measured=measured,
        healthy=range_of(healthy[baselines].tolist()),
        spread=range_of([*spread.low[baselines].tolist(), *spread.high[baselines].tolist()]),
        replicates=spread,
        n_healthy=int(np.isfinite(values[sources]).sum()),
        n_run=int(np.isfinite(values[kept]).sum()),
        fixed=fixed,
        matched=matched,
        over={
            axis.name: tuple(_group_change(group, values, fixed, matched) for group in axis.groups)
            for axis in axes
        },
    )


def _group_change(group: Group, values: NDArray[np.float64], fixed: Changes, matched: Changes) -> GroupChange:
    rows = group.rows & np.isfinite(values)
    return GroupChange(
        group,
        int(rows.sum()),
        range_of(values[rows].tolist()),
        _percent_range(fixed, rows),
        _percent_range(matched, rows),
        range_of(fixed.absolute[rows].tolist()),
        range_of(matched.absolute[rows].tolist()),
        _all_healthy(fixed, rows),
        _all_healthy(matched, rows),
    )


def _percent_range(changes: Changes, rows: NDArray[np.bool_]) -> Range:
    """The range in percent, if every change has a percentage."""
    known = rows & np.isfinite(changes.absolute)
    percent = changes.percent[known].tolist()
    return range_of(percent if np.isfinite(percent).all() else [])


def _all_healthy(changes: Changes, rows: NDArray[np.bool_]) -> bool:
    known = rows & np.isfinite(changes.absolute)
    return bool(known.any() and changes.is_healthy[known].all())


def _unmeasured(measured: MeasuredIndicator, data: ExperimentData, kept: NDArray[np.bool_]) -> dict[int, str]:
    """Reasons why runs have no number: how they ended, or what is missing in their records."""
    reasons = {}
    for row in np.flatnonzero(kept & ~measured.has_number).tolist():
        status = str(data.columns[names.STATUS][row])
        reasons[row] = measured.obstacle(row) if status == "ok" else status
    return reasons
