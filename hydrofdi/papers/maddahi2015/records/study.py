"""The paper's study as plain data for JSON."""

from __future__ import annotations

from typing import Any

from hydrofdi.papers.maddahi2015.deviations import Deviation
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.papers.maddahi2015.records.claims import claims_record
from hydrofdi.papers.maddahi2015.records.controls import controls_record
from hydrofdi.papers.maddahi2015.records.scenarios import scenarios_record
from hydrofdi.papers.maddahi2015.scenarios.study import ScenarioStudy
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.papers.maddahi2015.views import asked_views
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.record import general_record
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
        | {key: value for _, data in asked_views(study) for key, value in data.items()}
        | {
            "claims": claims_record(study),
            "guarded_claims": list(study.data.experiment.claims),
            "controls": controls_record(study),
            "reference": [_deviation_record(deviation) for deviation in study.deviations],
        }
        | _lack_record(study.grid)
    )


def _ensemble_record(study: Study, scenarios: ScenarioStudy) -> dict[str, Any]:
    views = {key: value for _, data in asked_views(study) for key, value in data.items()}
    return (
        general_record(study, with_rows=False)
        | views
        | {
            "claims": claims_record(study),
            "guarded_claims": list(study.data.experiment.claims),
            "controls": {"sealed_alarms": [], "best_level_matched": []},
            "reference": [],
            "scenarios": scenarios_record(scenarios),
        }
    )


def _lack_record(grid: ModeGrid) -> dict[str, str]:
    """Why the claims are not evaluated, where they are not."""
    return {"claims_not_evaluated": grid.lack} if grid.lack else {}


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
