"""A report as plain data for JSON."""

from __future__ import annotations

import io
import json
from collections import Counter
from typing import Any

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.contract import ComposedReport
from hydrofdi.report.external import ExternalStudy
from hydrofdi.report.forms.indicators_record import indicator_record, output_values
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.forms.replicates_record import replicates_record
from hydrofdi.report.runs.rows import TableRow, largest_positive, level_name
from hydrofdi.store.layout import names
from hydrofdi.units import convert


def general_record(analysis: Analysis, *, with_rows: bool = True) -> dict[str, Any]:
    """Data of every experiment, with or without its rows; missing numbers are None."""
    rows = analysis.table.rows if with_rows else ()
    replicates = analysis.replicates
    return (
        {
            "experiment": analysis.table.name,
            "rows": [_row_record(row) | _measured_record(analysis, row.position) for row in rows],
            "verdicts": _verdict_counts(analysis),
        }
        | ({} if analysis.has_baseline else {"delta_not_known": analysis.missing_baseline})
        | _external_record(analysis.external)
        | ({} if replicates is None else {"replicates": replicates_record(replicates)})
        | _indicators_record(analysis)
    )


def render_json(report: ComposedReport) -> str:
    """A report as JSON."""
    text = io.StringIO()
    json.dump(report.record(), text, indent=2, allow_nan=False)
    return text.getvalue() + "\n"


def _row_record(row: TableRow) -> dict[str, Any]:
    return {
        "run_id": row.run_id,
        "leakage_L_per_min": finite(convert(row.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        "internal_leakage_coefficient": finite(row.leakage_coefficient),
        "mean_internal_leakage_L_per_min": finite(convert(row.mean_leakage_flow, "L/min")),
        "mean_external_leakage_L_per_min": [finite(convert(flow, "L/min")) for flow in row.external.flows],
        "mean_chamber_1_pressure_Pa": finite(row.mean_pressure),
        "hydraulic_mode_Hz": finite(row.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(row.mode_damping_ratio),
        "detail_rms_Pa": [finite(value) for value in row.detail_rms],
        "delta_fixed_percent": [finite(value) for value in row.delta_fixed],
        "delta_matched_percent": [finite(value) for value in row.delta_matched],
        "largest_positive_fixed": level_name(largest_positive(row.delta_fixed)),
        "largest_positive_matched": level_name(largest_positive(row.delta_matched)),
        "approximation_rms_Pa": [finite(value) for value in row.approximations.rms],
        "approximation_delta_fixed_percent": [finite(value) for value in row.approximations.fixed],
        "approximation_delta_matched_percent": [finite(value) for value in row.approximations.matched],
        "settled_detail_rms_Pa": [finite(value) for value in row.settled_details.rms],
        "settled_delta_fixed_percent": [finite(value) for value in row.settled_details.fixed],
        "settled_delta_matched_percent": [finite(value) for value in row.settled_details.matched],
        "settled_approximation_rms_Pa": [finite(value) for value in row.settled_approximations.rms],
        "settled_approximation_delta_fixed_percent": [
            finite(value) for value in row.settled_approximations.fixed
        ],
        "settled_approximation_delta_matched_percent": [
            finite(value) for value in row.settled_approximations.matched
        ],
        "labels": row.labels,
        "sealed": row.is_sealed,
        "status": row.status,
        "message": row.message,
        "verdict": row.verdict,
    }


def _verdict_counts(analysis: Analysis) -> dict[str, int]:
    return dict(Counter(row.verdict for row in analysis.table.rows))


def _external_record(study: ExternalStudy | None) -> dict[str, Any]:
    if study is None:
        return {}
    states = [
        {
            "external_leakage_of": list(state.chambers),
            "runs": len(state.rows),
            "ranges_percent": {
                name: [finite(span.low), finite(span.high)] for name, span in study.ranges(state).items()
            },
            "gap_percentage_points": {name: finite(gap) for name, gap in study.gaps(state).items()},
        }
        for state in study.states
    ]
    return {"external_leakage": {"approximation": study.name, "states": states}}


def _measured_record(analysis: Analysis, row: int) -> dict[str, Any]:
    """Values that the indicators measured for a run."""
    if not analysis.indicators:
        return {}
    values: dict[str, Any] = {}
    for study in analysis.indicators:
        values |= output_values(study, row)
    return {"indicators": values}


def _indicators_record(analysis: Analysis) -> dict[str, Any]:
    if not analysis.indicators:
        return {}
    run_ids = analysis.data.columns[names.RUN_ID].astype(str).tolist()
    return {"indicators": [indicator_record(study, run_ids) for study in analysis.indicators]}
