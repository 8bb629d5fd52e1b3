"""Outputs of indicators over the runs of an experiment, against healthy runs."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import DWT
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.contract import Output
from hydrofdi.report.document import Block
from hydrofdi.report.runs import Array, of_healthy, span_text
from hydrofdi.settings.messages import HOLE, convert, readable_unit
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.tables.table import Column, Table, group_breaks, plain

LEAST_SHARE = 0.01
"""A healthy value below this share of the largest size over all runs counts as near zero."""


def span_of(values: Array) -> tuple[float, float]:
    """Smallest and largest of some numbers, without NaN; NaN if there is none."""
    known = values[~np.isnan(values)].tolist()
    return min(known, default=math.nan), max(known, default=math.nan)


def relative_change(healthy: Array, values: Array) -> Array:
    """Change from a healthy value in percent of its size, above zero if the number rose.

    NaN if the healthy value is near zero: its size is below 1 % of the largest size over all runs.
    """
    largest = np.nanmax(np.abs(values), initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        known = np.abs(healthy) > LEAST_SHARE * largest
        change: Array = np.where(known, 100.0 * (values - healthy) / np.abs(healthy), np.nan)
    return change


@dataclass(frozen=True)
class ReportedOutput:
    """An output of an indicator over an experiment.

    Attributes
    ----------
    values : ndarray, shape (n_run, *dims)
        In the unit of the output; NaN if a run has none.
    """

    label: str
    output: Output
    values: Array
    data: ExperimentData

    @property
    def variable(self) -> str:
        """``label.output``."""
        return f"{self.label}.{self.output.name}"

    @property
    def title(self) -> str:
        """The same with the dimensions of its mean."""
        over = " and ".join(self.output.dims)
        return f"{self.variable} (mean over {over})" if over else self.variable

    @property
    def unit(self) -> str:
        """The unit in which a person reads it; empty if it has none."""
        largest = float(np.abs(self.means[np.isfinite(self.means)]).max(initial=0.0))
        unit = readable_unit(self.output.unit, largest)
        return "" if unit == "1" else unit

    def shown(self, values: Array) -> Array:
        """Numbers in the unit of the output, in `unit`."""
        return values * convert(1.0, self.unit, self.output.unit)

    @cached_property
    def means(self) -> Array:
        """The mean over all its dimensions, shape (n_run,); NaN if there is no number."""
        flat = self.values.reshape(len(self.values), -1)
        known = np.isfinite(flat)
        with np.errstate(invalid="ignore"):
            means: Array = np.where(known, flat, 0.0).sum(axis=1) / known.sum(axis=1)
        return means

    @property
    def healthy(self) -> Array:
        """The values of the fixed baselines."""
        rows = self.data.fixed_baseline
        healthy: Array = self.means[np.unique(rows[rows != names.NO_BASELINE])]
        return healthy


@dataclass(frozen=True)
class MeasuredIndicator:
    """An indicator over an experiment under its label, and row → reason of a run without any number."""

    label: str
    indicator: Indicator[Any]
    outputs: tuple[ReportedOutput, ...]
    unmeasured: dict[int, str]


def measured_indicators(data: ExperimentData) -> tuple[MeasuredIndicator, ...]:
    """The stored indicators of an experiment, except that of the details."""
    made = data.indicators.items()
    measured = (measured_indicator(label, indicator, data) for label, indicator in made if label != DWT)
    return tuple(indicator for indicator in measured if indicator)


def measured_indicator(
    label: str, indicator: Indicator[Any], data: ExperimentData
) -> MeasuredIndicator | None:
    """An indicator with those of its outputs that are stored, and reasons of runs without any."""
    outputs = tuple(
        ReportedOutput(label, output, data.columns[f"{label}.{output.name}"], data)
        for output in indicator.outputs
        if f"{label}.{output.name}" in data.columns
    )
    if not outputs:
        return None
    has_number = np.isfinite([output.means for output in outputs]).any(axis=0)
    obstacles, reasons = data.columns.get(f"{label}{names.OBSTACLE}"), {}
    for row in np.flatnonzero(~has_number).tolist():
        status = str(data.columns[names.STATUS][row])
        obstacle = "" if obstacles is None else str(obstacles[row])
        reasons[row] = (obstacle or indicator.absence) if status == "ok" else status
    return MeasuredIndicator(label, indicator, outputs, reasons)


def indicators_block(studies: tuple[MeasuredIndicator, ...]) -> Block | None:
    """Outputs of the indicators beside the details without a leak, and what has none; None without any."""
    if not studies:
        return None
    reasons = Counter((study.label, why) for study in studies for why in study.unmeasured.values())
    unmeasured = [{"indicator": label, "runs": n, "reason": why} for (label, why), n in reasons.items()]
    holes = Table.of_records(unmeasured, title="Could not be measured", key="indicator-holes")
    outputs = [output for study in studies for output in study.outputs]
    columns = [
        Column("Output", [output.title for output in outputs], is_text=True),
        Column("Meaning", [output.output.long_name for output in outputs], is_text=True),
        Column("Unit", [output.unit or HOLE for output in outputs], is_text=True),
        Column("Value", [_healthy(output) for output in outputs]),
        Column("Healthy runs", [int(np.isfinite(output.healthy).sum()) for output in outputs]),
    ]
    title = "Outputs without a leak, under the conditions of the fixed baseline"
    breaks = group_breaks([output.label for output in outputs])
    table = Table(tuple(columns), title, "indicator-outputs", breaks=breaks)
    return Block("indicators", "Indicators", (), (table, holes))


def _healthy(output: ReportedOutput) -> str:
    """The range of the healthy runs in the unit that people read."""
    low, high = output.shown(np.array(span_of(output.healthy))).tolist()
    return HOLE if math.isnan(low) else span_text(f"{low:.4g}", f"{high:.4g}")


def indicator_record(study: MeasuredIndicator) -> dict[str, Any]:
    """An indicator: what it is, its outputs with their changes over each axis, and what has no number."""
    return {
        "label": study.label,
        "indicator": study.indicator.name,
        "version": study.indicator.version,
        "channels": sorted(study.indicator.channels),
        "options": study.indicator.options.model_dump(mode="json"),
        "outputs": [_output_record(output) for output in study.outputs],
        "not_measured": [
            {"run_id": str(study.outputs[0].data.columns[names.RUN_ID][row]), "why": why}
            for row, why in study.unmeasured.items()
        ],
    }


def _output_record(measured: ReportedOutput) -> dict[str, Any]:
    output = measured.output
    return {
        "name": output.name,
        "unit": output.unit,
        "long_name": output.long_name,
        "dims": dict(output.dims),
        "runs": int(np.isfinite(measured.means).sum()),
        "healthy_runs": int(np.isfinite(measured.healthy).sum()),
        "healthy": plain(span_of(measured.healthy)),
    }


def output_columns(study: MeasuredIndicator, rows: NDArray[np.int64]) -> dict[str, Any]:
    """Header with unit → number of each run, and its changes; each number of an array by itself.

    If a run of the experiment could not be measured, ``label.obstacle`` gives the reason.
    """
    columns: dict[str, Any] = {}
    for output in study.outputs:
        name, unit, data = output.variable, output.output.unit, output.data
        shown = "" if unit == "1" else f" [{unit}]"
        for index in np.ndindex(output.values.shape[1:]):
            suffix = "".join(f"[{part}]" for part in index)
            columns[f"{name}{suffix}{shown}"] = output.values[(rows, *index)]
        for kind, baseline in data.baselines.items():
            healthy, change = of_healthy(output.means, baseline), f"{name} change_{kind}"
            columns[f"{change} [%]"] = relative_change(healthy, output.means)[rows]
            columns[f"{change}{shown}"] = (output.means - healthy)[rows]
    if study.unmeasured:
        reasons = [study.unmeasured.get(row, "") for row in rows.tolist()]
        columns[f"{study.label}{names.OBSTACLE}"] = reasons
    return columns
