"""Claims as plain data."""

from __future__ import annotations

import math
from typing import Any

from hydrofdi.papers.maddahi2015.claims import CheckResult, ClaimResult
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.papers.maddahi2015.records.phases import labels_record, phases_record
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.wording import mode_name


def claims_record(study: Study) -> list[dict[str, Any]]:
    """Every claim with its checks, and how it stands over the start phases; an ensemble leaves out checks."""
    return [_claim_record(result) | _details(study, result) for result in study.claims]


def _details(study: Study, result: ClaimResult) -> dict[str, Any]:
    checks = result.checks if study.scenarios is None else ()
    return {"checks": [_check_record(check, study.grid) for check in checks]} | _claim_standing(
        study, result.claim.id
    )


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
    } | labels_record(grid.scenarios[check.scenario])


def _claim_standing(study: Study, claim: str) -> dict[str, Any]:
    """How a claim stands over the start phases, and in the settled records."""
    configured, *settled = study.standings
    record = phases_record(configured.claims[claim], "margin_percentage_points")
    for standing in settled:
        margin = standing.margins[claim]
        record["settled"] = {
            "reproduced": None if math.isnan(margin) else margin > 0.0,
            "margin_percentage_points": finite(margin),
            **phases_record(standing.claims[claim], "margin_percentage_points"),
        }
    return record
