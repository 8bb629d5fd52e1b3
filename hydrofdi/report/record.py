"""A report as data for programs: JSON, and tidy columns for CSV and Parquet."""

from __future__ import annotations

import io
import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrofdi.config.request import parameter_unit
from hydrofdi.report.indicators import indicator_record, output_columns
from hydrofdi.report.runs import Array, RunTable, best_levels, level_names
from hydrofdi.report.table import Table, plain
from hydrofdi.store.layout import names
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.report.data import ReportData
    from hydrofdi.report.table import ComposedReport

_DELTAS = {
    names.DETAIL_RMS: "delta",
    names.APPROXIMATION_RMS: "approximation_delta",
    names.SETTLED_DETAIL_RMS: "settled_delta",
    names.SETTLED_APPROXIMATION_RMS: "settled_approximation_delta",
}
"""Variable → how data for programs name its δ."""

_BASELINES = ("fixed", "matched")


def general_record(report: ReportData, *, with_rows: bool = True) -> dict[str, Any]:
    """Data of every experiment, with or without its rows; missing numbers are None."""
    table = report.table
    record: dict[str, Any] = {"experiment": report.data.experiment.name}
    record["rows"] = _row_records(report) if with_rows else []
    record["verdicts"] = dict(Counter(table.verdicts))
    if not report.has_baseline:
        record["delta_not_known"] = report.no_changes
    if report.indicators:
        record["indicators"] = [indicator_record(each) for each in report.indicators]
    return record


def render_json(report: ComposedReport) -> str:
    """A report as JSON."""
    text = io.StringIO()
    json.dump(report.record(), text, indent=2, allow_nan=False)
    return text.getvalue() + "\n"


def _run_columns(table: RunTable) -> dict[str, Any]:
    """A value for each run, in readable units."""
    return {
        "run_id": table.texts(names.RUN_ID),
        "leakage_L_per_min": _converted(table.leakage_flows, "L/min"),
        "bulk_modulus_MPa": _converted(table[names.BULK_MODULUS], "MPa"),
        "internal_leakage_coefficient": table[names.LEAKAGE_COEFFICIENT],
        "mean_internal_leakage_L_per_min": _converted(table[names.MEAN_LEAKAGE_FLOW], "L/min"),
        "mean_external_leakage_L_per_min": [_converted(pair, "L/min") for pair in table.external_flows],
        "mean_chamber_1_pressure_Pa": table[names.MEAN_CHAMBER_1_PRESSURE],
        "hydraulic_mode_Hz": table[names.MODE_FREQUENCY],
        "hydraulic_mode_damping_ratio": table[names.MODE_DAMPING_RATIO],
    }


def _level_columns(table: RunTable) -> dict[str, Array]:
    """A number for each run and level: RMS, and δ against either baseline."""
    columns = {}
    for name, delta in _DELTAS.items():
        columns[f"{name}_Pa"] = table[name]
        columns |= {f"{delta}_{each}_percent": table.changes(each, name) for each in _BASELINES}
    return columns


def _row_records(report: ReportData) -> list[dict[str, Any]]:
    table = report.table
    columns = _run_columns(table) | _level_columns(table)
    for baseline in _BASELINES:
        columns[f"largest_positive_{baseline}"] = level_names(best_levels(table.changes(baseline)))
    columns |= {
        "labels": table.labels,
        "sealed": table.is_sealed,
        "status": table.texts(names.STATUS),
        "message": table.texts(names.MESSAGE),
        "verdict": table.verdicts,
    }
    measured = {
        output.variable: output.values[table.positions]
        for study in report.indicators
        for output in study.outputs
    }
    if measured:
        columns["indicators"] = [*Table.of(measured)]
    return [*Table.of(columns)]


def tidy_columns(report: ReportData) -> dict[str, list[Any]]:
    """Header with unit → values, one per run and level; None if a number is missing."""
    table = report.table
    columns = _run_columns(table)
    flows = columns.pop("mean_external_leakage_L_per_min")
    columns |= {f"mean_external_leakage_{c}_L_per_min": [pair[c - 1] for pair in flows] for c in (1, 2)}
    columns["internal_leakage_coefficient_m3.5_per_kg0.5"] = columns.pop("internal_leakage_coefficient")
    columns |= {_si_header(name): table.values(name) for name in table.label_names}
    levels = range(table.n_level)
    by_level: dict[str, Any] = {"level": [level_names(levels)] * len(table)} | _level_columns(table)
    for baseline in _BASELINES:
        is_best = best_levels(table.changes(baseline))[:, None] == np.array(levels)
        by_level[f"largest_positive_{baseline}"] = is_best.astype(int)
    columns |= by_level
    for study in report.indicators:
        columns |= output_columns(study, table.positions)
    columns |= {"status": table.texts(names.STATUS), "verdict": table.verdicts}
    return {
        header: [
            value for row in plain(own) for value in (row if header in by_level else [row] * len(levels))
        ]
        for header, own in columns.items()
    }


def wide_columns(report: ReportData) -> dict[str, list[Any]]:
    """Header with unit → values, one per run: what varies, and δ of each level against the fixed baseline."""
    table = report.table
    columns: dict[str, Any] = {"run_id": table.texts(names.RUN_ID)}
    columns["leakage_L_per_min"] = _converted(table.leakage_flows, "L/min")
    columns["bulk_modulus_MPa"] = _converted(table[names.BULK_MODULUS], "MPa")
    columns["internal_leakage_coefficient_m3.5_per_kg0.5"] = table[names.LEAKAGE_COEFFICIENT].tolist()
    columns |= {_si_header(name): table.values(name) for name in table.label_names}
    deltas = enumerate(table.changes("fixed").T if report.has_details else (), 1)
    columns |= {f"delta_d{level}_percent": own.tolist() for level, own in deltas}
    for study in report.indicators:
        columns |= output_columns(study, table.positions)
    return plain(columns | {"status": table.texts(names.STATUS), "verdict": table.verdicts})  # type: ignore[no-any-return]


def _converted(values: Array, unit: str) -> list[float]:
    return [convert(value, unit) for value in values.tolist()]


def _si_header(name: str) -> str:
    """A varied parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
