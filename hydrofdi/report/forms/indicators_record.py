"""Indicators as plain data for JSON, and as columns."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrofdi.report.axes import Axis
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.indicators.changes import Changes
from hydrofdi.report.indicators.study import GroupChange, IndicatorStudy, OutputStudy
from hydrofdi.report.ranges import Range
from hydrofdi.store.layout.names import OBSTACLE


def indicator_record(study: IndicatorStudy, run_ids: list[str]) -> dict[str, Any]:
    """An indicator: what it is, its outputs with their changes over each axis, and what has no number."""
    indicator = study.measured.indicator
    return {
        "label": study.measured.label,
        "indicator": indicator.name,
        "version": indicator.version,
        "channels": sorted(indicator.channels),
        "options": indicator.options.model_dump(mode="json"),
        "not_affected_by": [axis.name for axis in study.idle_axes],
        "outputs": [_output_record(study, output) for output in study.outputs],
        "not_measured": [{"run_id": run_ids[row], "why": why} for row, why in study.unmeasured.items()],
    }


def _output_record(study: IndicatorStudy, output: OutputStudy) -> dict[str, Any]:
    described = output.measured.output
    return {
        "name": described.name,
        "unit": described.unit,
        "long_name": described.long_name,
        "dims": dict(described.dims),
        "runs": output.n_run,
        "healthy_runs": output.n_healthy,
        "healthy": _range_record(output.healthy),
        "healthy_change": _range_record(output.spread) if study.has_replicates else None,
        "changes": [
            _change_record(axis, change, study.has_replicates)
            for axis in study.axes
            for change in output.over[axis.name]
        ],
    }


def _change_record(axis: Axis, change: GroupChange, has_replicates: bool) -> dict[str, Any]:
    return {
        "parameter": axis.name,
        "value": change.group.value,
        "text": change.group.text,
        "runs": change.n_run,
        "values": _range_record(change.values),
        "change_fixed": _range_record(change.fixed_absolute),
        "change_matched": _range_record(change.matched_absolute),
        "change_fixed_percent": _range_record(change.fixed),
        "change_matched_percent": _range_record(change.matched),
        "within_healthy_fixed": change.fixed_is_healthy if has_replicates else None,
        "within_healthy_matched": change.matched_is_healthy if has_replicates else None,
    }


def _range_record(span: Range) -> list[float | None]:
    return [finite(span.low), finite(span.high)]


def output_values(study: IndicatorStudy, row: int) -> dict[str, Any]:
    """``label.output`` → number of a run, or the numbers of an array; None if it has none."""
    return {
        study.measured.variable(output.measured): _plain(output.measured.values[row])
        for output in study.outputs
    }


def _plain(values: Any) -> Any:
    return finite(float(values)) if np.ndim(values) == 0 else [_plain(part) for part in values]


def output_columns(study: IndicatorStudy, row: int) -> dict[str, float | str | None]:
    """Header with unit → number of a run, and its changes; each number of an array by itself.

    If a run of the experiment could not be measured, ``label.obstacle`` gives the reason.
    """
    columns: dict[str, float | str | None] = {}
    for output in study.outputs:
        name, unit = study.measured.variable(output.measured), output.measured.output.unit
        shown = "" if unit == "1" else f" [{unit}]"
        values = output.measured.values[row]
        for place in np.ndindex(values.shape):
            index = "".join(f"[{part}]" for part in place)
            columns[f"{name}{index}{shown}"] = finite(float(values[place]))
        for kind, changes in (("fixed", output.fixed), ("matched", output.matched)):
            columns |= _change_columns(f"{name} change_{kind}", shown, changes, row, study.has_replicates)
    if study.unmeasured:
        columns[f"{study.measured.label}{OBSTACLE}"] = study.unmeasured.get(row, "")
    return columns


def _change_columns(
    name: str, unit: str, changes: Changes, row: int, has_replicates: bool
) -> dict[str, float | str | None]:
    """A change in both units; with replicates also the healthy range, and 1 if the change is within it."""
    columns: dict[str, float | str | None] = {
        f"{name} [%]": finite(float(changes.percent[row])),
        f"{name}{unit}": finite(float(changes.absolute[row])),
    }
    if has_replicates:
        columns[f"{name} healthy_low{unit}"] = finite(float(changes.low[row]))
        columns[f"{name} healthy_high{unit}"] = finite(float(changes.high[row]))
        columns[f"{name} within_healthy"] = int(changes.is_healthy[row])
    return columns
