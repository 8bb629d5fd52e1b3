"""A report as plain data for JSON."""

from __future__ import annotations

import io
import json
import math
from collections import Counter
from typing import Any

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.claims import D3, CheckResult, Verdict
from hydrofdi.report.controls import BestLevel, SealedAlarm
from hydrofdi.report.deviations import Deviation
from hydrofdi.report.external import ExternalStudy
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.forms.readings_record import readings_record
from hydrofdi.report.forms.replicates_record import replicates_record
from hydrofdi.report.modes import ModeGrid
from hydrofdi.report.phases import PhaseCount
from hydrofdi.report.readings import ReadingsStudy
from hydrofdi.report.table import TableRow, largest_positive, level_name
from hydrofdi.report.wording import mode_name
from hydrofdi.units import convert


def report_record(analysis: Analysis) -> dict[str, Any]:
    """A report; numbers that do not exist are None.

    The thousands of runs, checks and controls of an ensemble are left to the tidy forms; what they come to in
    each reading stands under ``readings``.
    """
    if analysis.readings is not None:
        return _ensemble_record(analysis, analysis.readings)
    return (
        {
            "experiment": analysis.table.name,
            "rows": [_row_record(row) for row in analysis.table.rows],
            "verdicts": _verdict_counts(analysis),
            "claims": [
                _verdict_record(verdict)
                | {"checks": [_check_record(check, analysis.grid) for check in verdict.checks]}
                | _claim_standing(analysis, verdict.claim.id)
                for verdict in analysis.verdicts
            ],
            "guarded_claims": list(analysis.data.experiment.claims),
            "controls": {
                "sealed_alarms": [
                    _alarm_record(alarm) | _alarm_standing(analysis, place)
                    for place, alarm in enumerate(analysis.sealed_alarms)
                ],
                "best_level_matched": [
                    _best_level_record(mode) | _best_level_standing(analysis, place)
                    for place, mode in enumerate(analysis.best_levels)
                ],
            },
            "reference": [_deviation_record(deviation) for deviation in analysis.deviations],
        }
        | _external_record(analysis.external)
        | _lack_record(analysis.grid)
        | ({} if analysis.replicates is None else {"replicates": replicates_record(analysis.replicates)})
    )


def _ensemble_record(analysis: Analysis, study: ReadingsStudy) -> dict[str, Any]:
    claims = [
        _verdict_record(verdict) | _claim_standing(analysis, verdict.claim.id) | {"checks": []}
        for verdict in analysis.verdicts
    ]
    return {
        "experiment": analysis.table.name,
        "rows": [],
        "verdicts": _verdict_counts(analysis),
        "claims": claims,
        "guarded_claims": list(analysis.data.experiment.claims),
        "controls": {"sealed_alarms": [], "best_level_matched": []},
        "reference": [],
        "readings": readings_record(study),
    }


def render_json(analysis: Analysis) -> str:
    """A report as JSON."""
    text = io.StringIO()
    json.dump(report_record(analysis), text, indent=2, allow_nan=False)
    return text.getvalue() + "\n"


def _claim_standing(analysis: Analysis, claim: str) -> dict[str, Any]:
    """How a claim stands over the start phases, and in the settled records."""
    configured, *settled = analysis.standings
    record = _phases_record(configured.claims[claim], "margin_percentage_points")
    for standing in settled:
        margin = standing.margins[claim]
        record["settled"] = {
            "reproduced": None if math.isnan(margin) else margin > 0.0,
            "margin_percentage_points": finite(margin),
            **_phases_record(standing.claims[claim], "margin_percentage_points"),
        }
    return record


def _alarm_standing(analysis: Analysis, place: int) -> dict[str, Any]:
    configured, *settled = analysis.standings
    record = _phases_record(configured.alarms[place], "delta_d3_percent")
    for standing in settled:
        deltas = standing.alarm_deltas[place]
        record["settled"] = {
            "alarm": None if any(map(math.isnan, deltas)) else largest_positive(deltas) == D3,
            "delta_fixed_percent": [finite(value) for value in deltas],
            **_phases_record(standing.alarms[place], "delta_d3_percent"),
        }
    return record


def _best_level_standing(analysis: Analysis, place: int) -> dict[str, Any]:
    configured, *settled = analysis.standings
    record = _phases_record(configured.best_levels[place], "delta_matched_percent")
    for standing in settled:
        record["settled"] = _phases_record(standing.best_levels[place], "delta_matched_percent")
    return record


def _phases_record(count: PhaseCount, quantity: str) -> dict[str, Any]:
    numbers = {"least": count.least, "mean": count.mean, "largest": count.largest}
    return {
        "phases": {
            "held": count.held,
            "of": count.of,
            quantity: {name: finite(value) for name, value in numbers.items()},
        }
    }


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


def _lack_record(grid: ModeGrid) -> dict[str, str]:
    """Why the claims are not evaluated, where they are not."""
    return {"claims_not_evaluated": grid.lack} if grid.lack else {}


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


def _verdict_record(verdict: Verdict) -> dict[str, Any]:
    return {
        "id": verdict.claim.id,
        "sentence": verdict.claim.sentence,
        "rule": verdict.claim.rule,
        "reproduced": verdict.reproduced,
        "margin_percentage_points": finite(verdict.margin),
        "each_may_move_percentage_points": finite(verdict.allowance),
    }


def _check_record(check: CheckResult, grid: ModeGrid) -> dict[str, Any]:
    return {
        "runs": list(check.run_ids),
        "modes": [mode_name(grid.leakage_flows[q], grid.bulk_moduli[b]) for q, b in check.modes],
        "holds": check.holds,
        "margin_percentage_points": finite(check.margin),
        "each_may_move_percentage_points": finite(check.allowance),
    } | _labels(grid.readings[check.reading])


def _alarm_record(alarm: SealedAlarm) -> dict[str, Any]:
    return {
        "bulk_modulus_MPa": convert(alarm.bulk_modulus, "MPa"),
        "alarm": alarm.alarm,
        "delta_fixed_percent": [finite(value) for value in alarm.delta_fixed],
    } | _labels(alarm.labels)


def _best_level_record(mode: BestLevel) -> dict[str, Any]:
    return {
        "leakage_L_per_min": finite(convert(mode.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(mode.bulk_modulus, "MPa"),
        "level": level_name(mode.level),
        "delta_matched_percent": finite(mode.delta),
    } | _labels(mode.labels)


def _labels(labels: dict[str, Any]) -> dict[str, Any]:
    return {"labels": labels} if labels else {}


def _deviation_record(deviation: Deviation) -> dict[str, Any]:
    cell = deviation.cell
    return {
        "leakage_L_per_min": convert(cell.leakage, "L/min"),
        "bulk_modulus_MPa": convert(cell.bulk_modulus, "MPa"),
        "level": cell.level,
        "quantity": "delta_fixed_percent" if cell.delta is not None else "detail_rms_Pa",
        "published": deviation.published,
        "computed": finite(deviation.computed),
        "deviation": finite(deviation.deviation),
        "tolerance": deviation.tolerance,
        "agrees": deviation.agrees,
    }
