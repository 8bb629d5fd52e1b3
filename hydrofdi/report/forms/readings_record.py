"""The readings study as plain data for JSON."""

from __future__ import annotations

from typing import Any

from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.readings import CORE, Mask, ReadingsStudy, ValueShare
from hydrofdi.report.table import level_name
from hydrofdi.units import convert


def readings_record(study: ReadingsStudy) -> dict[str, Any]:
    """Counts over all readings, and each reading by itself."""
    core = study.reproducing(CORE)
    return {
        "readings": study.n_reading,
        "feasible": int(study.feasible.sum()),
        "infeasible": study.obstacles,
        "reproducing": _counts(study, study.feasible),
        "values": [_value_record(study, value) for value in study.value_shares],
        "sealed_alarms_where_C1_to_C4_hold": [
            {"bulk_modulus_MPa": convert(study.grid.bulk_moduli[beta], "MPa"), "alarms": int(count)}
            for beta, count in zip(study.grid.raised, study.alarms[core].sum(axis=0), strict=True)
        ],
        "best_level_matched_where_C1_to_C4_hold": [
            _best_level_record(study, mode, study.best_levels[core][:, column])
            for column, mode in enumerate(study.grid.modes())
        ],
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


def _best_level_record(study: ReadingsStudy, mode: tuple[int, int], best: Any) -> dict[str, Any]:
    levels = {level_name(level) or "": int((best == level).sum()) for level in range(study.grid.n_level)}
    return {
        "leakage_L_per_min": finite(convert(study.grid.leakage_flows[mode[0]], "L/min")),
        "bulk_modulus_MPa": convert(study.grid.bulk_moduli[mode[1]], "MPa"),
        "counts": levels | {"none": int((best < 0).sum())},
    }


def _member_record(study: ReadingsStudy, reading: int) -> dict[str, Any]:
    is_feasible = bool(study.feasible[reading])
    margins = study.margins.items()
    return {
        "values": study.grid.readings[reading],
        "outcome": study.outcomes[reading],
        "margins_percentage_points": {
            name: finite(float(margin[reading])) if is_feasible else None for name, margin in margins
        },
        "sealed_alarms": study.alarms[reading].tolist() if is_feasible else None,
    }
