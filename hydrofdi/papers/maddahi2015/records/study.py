"""The paper's study as plain data for JSON."""

from __future__ import annotations

import math
from typing import Any

from hydrofdi.papers.maddahi2015.claims import D3, CheckResult, ClaimResult
from hydrofdi.papers.maddahi2015.controls import BestLevel, SealedAlarm
from hydrofdi.papers.maddahi2015.deviations import Deviation
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.papers.maddahi2015.records.scenarios import scenarios_record
from hydrofdi.papers.maddahi2015.scenarios.study import ScenarioStudy
from hydrofdi.papers.maddahi2015.standings import PhaseCount
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.forms.record import general_record
from hydrofdi.report.runs.rows import largest_positive, level_name
from hydrofdi.report.wording import mode_name
from hydrofdi.units import convert


def study_record(study: Study) -> dict[str, Any]:
    """The record of any experiment with claims and controls; numbers that do not exist are None.

    The thousands of runs, checks and controls of an ensemble are left to the tidy forms; what they come to in
    each scenario stands under ``scenarios``.
    """
    if study.scenarios is not None:
        return _ensemble_record(study, study.scenarios)
    return (
        general_record(study)
        | {
            "claims": [
                _claim_record(result)
                | {"checks": [_check_record(check, study.grid) for check in result.checks]}
                | _claim_standing(study, result.claim.id)
                for result in study.claims
            ],
            "guarded_claims": list(study.data.experiment.claims),
            "controls": {
                "sealed_alarms": [
                    _alarm_record(alarm) | _alarm_standing(study, place)
                    for place, alarm in enumerate(study.sealed_alarms)
                ],
                "best_level_matched": [
                    _best_level_record(mode) | _best_level_standing(study, place)
                    for place, mode in enumerate(study.best_levels)
                ],
            },
            "reference": [_deviation_record(deviation) for deviation in study.deviations],
        }
        | _lack_record(study.grid)
    )


def _ensemble_record(study: Study, scenarios: ScenarioStudy) -> dict[str, Any]:
    return general_record(study, with_rows=False) | {
        "claims": [
            _claim_record(result) | _claim_standing(study, result.claim.id) | {"checks": []}
            for result in study.claims
        ],
        "guarded_claims": list(study.data.experiment.claims),
        "controls": {"sealed_alarms": [], "best_level_matched": []},
        "reference": [],
        "scenarios": scenarios_record(scenarios),
    }


def _claim_standing(study: Study, claim: str) -> dict[str, Any]:
    """How a claim stands over the start phases, and in the settled records."""
    configured, *settled = study.standings
    record = _phases_record(configured.claims[claim], "margin_percentage_points")
    for standing in settled:
        margin = standing.margins[claim]
        record["settled"] = {
            "reproduced": None if math.isnan(margin) else margin > 0.0,
            "margin_percentage_points": finite(margin),
            **_phases_record(standing.claims[claim], "margin_percentage_points"),
        }
    return record


def _alarm_standing(study: Study, place: int) -> dict[str, Any]:
    configured, *settled = study.standings
    record = _phases_record(configured.alarms[place], "delta_d3_percent")
    for standing in settled:
        deltas = standing.alarm_deltas[place]
        record["settled"] = {
            "alarm": None if any(map(math.isnan, deltas)) else largest_positive(deltas) == D3,
            "delta_fixed_percent": [finite(value) for value in deltas],
            **_phases_record(standing.alarms[place], "delta_d3_percent"),
        }
    return record


def _best_level_standing(study: Study, place: int) -> dict[str, Any]:
    configured, *settled = study.standings
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


def _lack_record(grid: ModeGrid) -> dict[str, str]:
    """Why the claims are not evaluated, where they are not."""
    return {"claims_not_evaluated": grid.lack} if grid.lack else {}


def _claim_record(result: ClaimResult) -> dict[str, Any]:
    return {
        "id": result.claim.id,
        "sentence": result.claim.sentence,
        "rule": result.claim.rule,
        "reproduced": result.reproduced,
        "margin_percentage_points": finite(result.margin),
        "each_may_move_percentage_points": finite(result.allowance),
    }


def _check_record(check: CheckResult, grid: ModeGrid) -> dict[str, Any]:
    return {
        "runs": list(check.run_ids),
        "modes": [mode_name(grid.leakage_flows[q], grid.bulk_moduli[b]) for q, b in check.modes],
        "holds": check.holds,
        "margin_percentage_points": finite(check.margin),
        "each_may_move_percentage_points": finite(check.allowance),
    } | _labels(grid.scenarios[check.scenario])


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
