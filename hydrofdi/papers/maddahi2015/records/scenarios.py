"""The scenarios study as plain data for JSON."""

from __future__ import annotations

from typing import Any

from hydrofdi.papers.maddahi2015.scenarios.study import CORE, Mask, ScenarioStudy
from hydrofdi.papers.maddahi2015.scenarios.values import ValueShare
from hydrofdi.report.forms.numbers import finite


def scenarios_record(study: ScenarioStudy) -> dict[str, Any]:
    """Counts over all scenarios, and each scenario by itself."""
    return {
        "scenarios": study.n_scenario,
        "feasible": int(study.feasible.sum()),
        "infeasible": study.obstacles,
        "reproducing": _counts(study, study.feasible),
        "values": [_value_record(study, value) for value in study.value_shares],
        "phases": study.configured.n_phase,
        "reproducing_in_all_phases": _phase_counts(study),
        "reproducing_settled": _settled_counts(study),
        "doubtful": {word: int((mask & study.feasible).sum()) for word, mask in study.doubts.items()},
        "sealed_alarms": _alarm_shares(study),
        "best_level_d2_matched_above_normal": _best_level_shares(study),
        "members": [_member_record(study, scenario) for scenario in range(study.n_scenario)],
    }


def _value_record(study: ScenarioStudy, value: ValueShare) -> dict[str, Any]:
    return {
        "parameters": list(value.parameters),
        "range" if value.is_range else "values": list(value.values),
        "scenarios": int(value.members.sum()),
        "feasible": int((value.members & study.feasible).sum()),
        "reproducing": _counts(study, value.members),
    }


def _counts(study: ScenarioStudy, members: Mask) -> dict[str, int | None]:
    sets = study.claim_sets.items()
    return {
        name: None if study.is_open(claims) else int((members & study.reproducing(claims)).sum())
        for name, claims in sets
    }


def _phase_counts(study: ScenarioStudy) -> dict[str, int | None]:
    """Feasible scenarios that reproduce claims at every start phase."""
    n_phase, sets = study.configured.n_phase, study.claim_sets.items()
    return {
        name: None
        if study.is_open(claims)
        else int((study.feasible & (study.configured.phases_held(claims) == n_phase)).sum())
        for name, claims in sets
    }


def _settled_counts(study: ScenarioStudy) -> dict[str, int] | None:
    """Feasible scenarios that reproduce claims in their settled records."""
    if study.settled is None:
        return None
    sets = study.claim_sets.items()
    return {name: int((study.feasible & study.settled.held(claims)).sum()) for name, claims in sets}


def _groups(study: ScenarioStudy) -> dict[str, Mask]:
    return {"feasible": study.feasible, "C1–C4": study.reproducing(CORE), "C4": study.reproducing(("C4",))}


def _alarm_shares(study: ScenarioStudy) -> dict[str, Any]:
    """Share of scenarios in which the d3 rule alarms at every β above the normal one, by group."""
    everywhere, throughout = study.configured.alarms_everywhere, study.configured.alarms_throughout
    return {
        name: {
            "alarms": _share_record(study, everywhere, members),
            "alarms_in_all_phases": _share_record(study, throughout, members),
        }
        for name, members in _groups(study).items()
    }


def _best_level_shares(study: ScenarioStudy) -> dict[str, Any]:
    """Share of the leaky modes above the normal EBM in which d2 is best, by group of scenarios."""
    columns = [k for k, (_, b) in enumerate(study.grid.modes()) if b in study.grid.raised]
    second = study.best_levels[:, columns] == 1
    return {name: _share_record(study, second, members) for name, members in _groups(study).items()}


def _share_record(study: ScenarioStudy, outcomes: Mask, members: Mask) -> dict[str, Any]:
    found = study.share(outcomes, members)
    interval = [finite(found.low), finite(found.high)] if study.is_drawn else None
    return {"count": found.count, "of": found.total, "interval_95": interval}


def _member_record(study: ScenarioStudy, scenario: int) -> dict[str, Any]:
    is_feasible = bool(study.feasible[scenario])
    margins = study.margins.items()
    return {
        "values": study.grid.scenarios[scenario],
        "outcome": study.outcomes[scenario],
        "margins_percentage_points": {
            name: finite(float(margin[scenario])) if is_feasible else None for name, margin in margins
        },
        "phases_held": {
            name: int(study.configured.phases_held((name,))[scenario]) if is_feasible else None
            for name in study.margins
        },
        "sealed_alarms": study.alarms[scenario].tolist() if is_feasible else None,
    }
