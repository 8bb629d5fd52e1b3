"""The readings study as plain data for JSON."""

from __future__ import annotations

from typing import Any

from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.readings import CORE, Mask, ReadingsStudy, ValueShare


def readings_record(study: ReadingsStudy) -> dict[str, Any]:
    """Counts over all readings, and each reading by itself."""
    return {
        "readings": study.n_reading,
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
        "members": [_member_record(study, reading) for reading in range(study.n_reading)],
    }


def _value_record(study: ReadingsStudy, value: ValueShare) -> dict[str, Any]:
    return {
        "parameters": list(value.parameters),
        "range" if value.is_range else "values": list(value.values),
        "readings": int(value.members.sum()),
        "feasible": int((value.members & study.feasible).sum()),
        "reproducing": _counts(study, value.members),
    }


def _counts(study: ReadingsStudy, members: Mask) -> dict[str, int | None]:
    sets = study.claim_sets.items()
    return {
        name: None if study.is_open(claims) else int((members & study.reproducing(claims)).sum())
        for name, claims in sets
    }


def _phase_counts(study: ReadingsStudy) -> dict[str, int | None]:
    """Feasible readings that reproduce claims at every start phase."""
    n_phase, sets = study.configured.n_phase, study.claim_sets.items()
    return {
        name: None
        if study.is_open(claims)
        else int((study.feasible & (study.configured.phases_held(claims) == n_phase)).sum())
        for name, claims in sets
    }


def _settled_counts(study: ReadingsStudy) -> dict[str, int] | None:
    """Feasible readings that reproduce claims in their settled records."""
    if study.settled is None:
        return None
    sets = study.claim_sets.items()
    return {name: int((study.feasible & study.settled.held(claims)).sum()) for name, claims in sets}


def _groups(study: ReadingsStudy) -> dict[str, Mask]:
    return {"feasible": study.feasible, "C1–C4": study.reproducing(CORE), "C4": study.reproducing(("C4",))}


def _alarm_shares(study: ReadingsStudy) -> dict[str, Any]:
    """Share of readings in which the d3 rule alarms at every β above the normal one, by group of readings."""
    everywhere, throughout = study.configured.alarms_everywhere, study.configured.alarms_throughout
    return {
        name: {
            "alarms": _share_record(study, everywhere, members),
            "alarms_in_all_phases": _share_record(study, throughout, members),
        }
        for name, members in _groups(study).items()
    }


def _best_level_shares(study: ReadingsStudy) -> dict[str, Any]:
    """Share of the leaky modes above the normal EBM in which d2 is best, by group of readings."""
    columns = [k for k, (_, b) in enumerate(study.grid.modes()) if b in study.grid.raised]
    second = study.best_levels[:, columns] == 1
    return {name: _share_record(study, second, members) for name, members in _groups(study).items()}


def _share_record(study: ReadingsStudy, outcomes: Mask, members: Mask) -> dict[str, Any]:
    found = study.share(outcomes, members)
    interval = [finite(found.low), finite(found.high)] if study.is_drawn else None
    return {"count": found.count, "of": found.total, "interval_95": interval}


def _member_record(study: ReadingsStudy, reading: int) -> dict[str, Any]:
    is_feasible = bool(study.feasible[reading])
    margins = study.margins.items()
    return {
        "values": study.grid.readings[reading],
        "outcome": study.outcomes[reading],
        "margins_percentage_points": {
            name: finite(float(margin[reading])) if is_feasible else None for name, margin in margins
        },
        "phases_held": {
            name: int(study.configured.phases_held((name,))[reading]) if is_feasible else None
            for name in study.margins
        },
        "sealed_alarms": study.alarms[reading].tolist() if is_feasible else None,
    }
