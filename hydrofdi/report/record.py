"""A report as data for programs: JSON, and tidy columns for CSV and Parquet."""

from __future__ import annotations

import io
import json
from collections import Counter
from typing import Any

from hydrofdi.config.request import parameter_unit
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import ComposedReport
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.indicators import indicator_record, output_columns, output_values
from hydrofdi.report.runs import TableRow, flow_numbers, largest_positive, level_name, row_numbers
from hydrofdi.store.layout import names
from hydrofdi.units import convert

_LEADING = ("largest_positive_fixed", "largest_positive_matched")


def general_record(analysis: Analysis, *, with_rows: bool = True) -> dict[str, Any]:
    """Data of every experiment, with or without its rows; missing numbers are None."""
    record: dict[str, Any] = {"experiment": analysis.table.name}
    record["rows"] = [_row_record(analysis, row) for row in (analysis.table.rows if with_rows else ())]
    record["verdicts"] = dict(Counter(row.verdict for row in analysis.table.rows))
    if not analysis.has_baseline:
        record["delta_not_known"] = analysis.missing_baseline
    if analysis.indicators:
        run_ids = analysis.data.columns[names.RUN_ID].astype(str).tolist()
        record["indicators"] = [indicator_record(study, run_ids) for study in analysis.indicators]
    return record


def render_json(report: ComposedReport) -> str:
    """A report as JSON."""
    text = io.StringIO()
    json.dump(report.record(), text, indent=2, allow_nan=False)
    return text.getvalue() + "\n"


def _row_record(analysis: Analysis, row: TableRow) -> dict[str, Any]:
    level, internal, *external = flow_numbers(row)
    leads = (level_name(largest_positive(each)) for each in (row.details.fixed, row.details.matched))
    measured = {k: v for study in analysis.indicators for k, v in output_values(study, row.position).items()}
    return {
        "run_id": row.run_id,
        "leakage_L_per_min": level,
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        "internal_leakage_coefficient": finite(row.leakage_coefficient),
        "mean_internal_leakage_L_per_min": internal,
        "mean_external_leakage_L_per_min": external,
        **row_numbers(row),
        **dict(zip(_LEADING, leads, strict=True)),
        "labels": row.labels,
        "sealed": row.is_sealed,
        "status": row.status,
        "message": row.message,
        "verdict": row.verdict,
    } | ({"indicators": measured} if analysis.indicators else {})


def tidy_columns(analysis: Analysis) -> dict[str, list[Any]]:
    """Header with unit → values, one per run and level; None if a number is missing."""
    lines = [line for row in analysis.table.rows for line in _lines(analysis, row)]
    return {header: [line[header] for line in lines] for header in lines[0]}


def _lines(analysis: Analysis, row: TableRow) -> list[dict[str, Any]]:
    """A line for each level of a run."""
    level, internal, *external = flow_numbers(row)
    numbers = row_numbers(row)
    by_level = {
        name: values
        for name, values in numbers.items()
        if isinstance(values, list) and name != "settled_approximation_rms_Pa"
    }
    best = [largest_positive(each) for each in (row.details.fixed, row.details.matched)]
    lead = {
        "run_id": row.run_id,
        "leakage_L_per_min": level,
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        **{_si_header(name): value for name, value in row.labels.items()},
        "internal_leakage_coefficient_m3.5_per_kg0.5": finite(row.leakage_coefficient),
        "mean_internal_leakage_L_per_min": internal,
        "mean_external_leakage_1_L_per_min": external[0],
        "mean_external_leakage_2_L_per_min": external[1],
        **{name: value for name, value in numbers.items() if not isinstance(value, list)},
    }
    end: dict[str, Any] = {}
    for study in analysis.indicators:
        end |= output_columns(study, row.position)
    end |= {"status": row.status, "verdict": row.verdict}
    return [
        lead
        | {"level": f"d{k + 1}"}
        | _with_leads({name: values[k] for name, values in by_level.items()}, [each == k for each in best])
        | end
        for k in range(analysis.table.n_level)
    ]


def _with_leads(numbers: dict[str, Any], leads: list[bool]) -> dict[str, Any]:
    """Numbers of a level, with whether it leads behind δ of the details."""
    names = [*numbers]
    first = {name: numbers[name] for name in names[:3]}
    return first | dict(zip(_LEADING, map(int, leads), strict=True)) | numbers


def _si_header(name: str) -> str:
    """A varied parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
