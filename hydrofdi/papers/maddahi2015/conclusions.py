"""Which sentences of the paper an experiment reproduces, and two controls that the paper does not have.

The controls are the d3 rule on a sealed actuator, and the matched baseline.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import CLAIMS, ClaimResult, Standing, alarms
from hydrofdi.papers.maddahi2015.data import StudyData, sealed_outcomes
from hydrofdi.report.runs import (
    Array,
    RunTable,
    best_levels,
    level_names,
)
from hydrofdi.report.table import Block, Table, plain
from hydrofdi.report.wording import joined
from hydrofdi.store.layout import names
from hydrofdi.units import convert

_ONE_PHASE = (
    "Only one start phase was measured. The decimated transform depends on it, so this is not a finding yet: "
    "set wavelet: {phase: all}."
)
_UNSETTLED = (
    "No run has settled features: no record holds two whole periods that agree. Lengthen record.duration."
)


def claim_record(study: StudyData, result: ClaimResult) -> dict[str, Any]:
    """A claim with its checks, and how it stands over the start phases; an ensemble leaves out checks."""
    claim = result.claim
    configured, *settled = (standing.claim(claim.id, study.looked_at) for standing in study.standings)
    record = {
        "id": claim.id,
        "sentence": claim.sentence,
        "rule": claim.rule,
        "reproduced": result.reproduced,
        "margin_percentage_points": result.margin,
        "each_may_move_percentage_points": result.allowance,
        "checks": [*study.check_records(result)] if study.scenarios is None else [],
        "phases": configured.phases("margin_percentage_points"),
    }
    for outcome in settled:
        record["settled"] = {
            "reproduced": None if math.isnan(outcome.number) else outcome.number > 0.0,
            "margin_percentage_points": outcome.number,
            "phases": outcome.phases("margin_percentage_points"),
        }
    return record


def claims_block(study: StudyData) -> Block:
    """All claims with their margins; one sentence if there is no grid."""
    title = "Claims: the paper's sentences as checks"
    if study.grid.lack:
        return Block("claims", title, (study.grid.lack, *required(study)))
    return Block("claims", title, required(study), (_claims_table(study),))


def required(study: StudyData) -> tuple[str, ...]:
    """Whether the claims that the file lists hold, in all feasible scenarios of an ensemble."""
    if not study.guarded:
        return ()
    lost = joined([each.claim.id for each in study.guarded if not each.reproduced])
    held = f"not so, or open, for {lost}" if lost else "all of them hold, at the configured start phase"
    return (f"The experiment file requires {joined([each.claim.id for each in study.guarded])}: {held}.",)


def _claims_table(study: StudyData) -> Table:
    note = (
        "At the configured start phase. Margin: how far one δ behind a claim could move before its result"
        " turns; negative if it does not hold. If it is a difference of two δ, both may move, each by half of"
        " it. –: open, cannot be decided (a run is missing, or the actuator does not move)."
    )
    records = [claim_record(study, each) for each in study.claims]
    nested = ("checks", "phases", "settled")
    return Table.of_records(plain(records), nested, title="Claims", key="claims", notes=(note,))


def standing_blocks(study: StudyData) -> tuple[Block, Block]:
    """Which claims and sealed alarms survive every start phase, as configured and settled; their numbers."""
    sentences = {claim.id: f"{claim.id}: {claim.sentence}" for claim in CLAIMS}
    named = [] if study.grid.lack else [(sentences[each.name], each) for each in study.claim_outcomes]
    named += [(f"d3 alarm at {each.name} without a leak", each) for each in study.alarm_outcomes]
    rows: dict[str, dict[str, Any]] = {}
    survival: dict[str, dict[str, Any]] = {}
    for name, each in named:
        lead = "" if each.records == study.standings[0].title else f"{each.records} "
        numbers = {end: each.spread[end] for end in ("least", "largest")} | {"number": each.number}
        row = rows.setdefault(name, {"what": name})
        row[f"{lead}phases"] = f"{each.held} of {each.of}" if each.of else None
        row |= {f"{lead}{key}": number for key, number in numbers.items()}
        survival.setdefault(name, {"claim": name})[each.records] = row[f"{lead}phases"]
    note = (
        "Phases in which it holds. Least, largest: margins in percentage points, δd3 in percent. Phase p: the"
        " record from its sample p on; phases of settled records repeat if a period has fewer samples."
        " Number: at the configured phase; of settled records that of the undecimated transform, free of"
        " boundaries, which holds all phases."
    )
    title = "Margins of the claims and δd3 of the sealed alarms over the start phases"
    table = Table.of_records([*rows.values()], title=title, key="phases-numbers", notes=(note,))
    has_phases = study.standings[0].n_phase > 1
    said = [] if has_phases else [_ONE_PHASE]
    said += [_UNSETTLED] if len(study.standings) == 1 else []
    held = Table.of_records(
        [*survival.values()] if has_phases else [], title="Start phases at which it holds"
    )
    title = "Claims and the sealed alarm over the start phases"
    return (
        Block("standing", "What survives: start phases and settled records", tuple(said), (held,)),
        Block("phases", title, (), (table,), ("phases",) if has_phases else ()),
    )


def alarm_verdicts(delta: Array) -> list[bool | None]:
    """Whether δd3 is positive and the largest of each run; None if it is missing or failed."""
    pairs = zip(alarms(delta), np.asarray(np.isnan(delta).any(axis=1)), strict=True)
    return [None if is_open else bool(is_alarm) for is_alarm, is_open in pairs]


def best_deltas(leaky: RunTable) -> tuple[NDArray[np.int64], Array]:
    """The level with the largest positive δ against the matched baseline, −1 if none is; and that δ [%]."""
    delta = leaky.changes("matched")
    best = best_levels(delta)
    return best, np.where(best < 0, np.nan, delta[np.arange(len(best)), best])


def controls_record(
    sealed: RunTable, leaky: RunTable, standings: Sequence[Standing]
) -> dict[str, list[dict[str, Any]]]:
    """What the d3 rule says of each run without any leak, and the best level of each leaky run."""
    best, deltas = best_deltas(leaky)

    def alarmed(standing: Standing) -> dict[str, Any]:
        shown = standing.shown[sealed.positions]
        outcomes = sealed_outcomes(sealed, standing)
        phases = [each.phases("delta_d3_percent") for each in outcomes]
        return {"alarm": alarm_verdicts(shown), "delta_fixed_percent": shown, "phases": phases}

    def ranked(standing: Standing) -> dict[str, Any]:
        at = zip(leaky.positions, best.tolist(), strict=True)
        outcomes = (standing.level("", standing.matched[:, position], level) for position, level in at)
        return {"phases": [each.phases("delta_matched_percent") for each in outcomes]}

    leads = {
        "leakage_L_per_min": [convert(flow, "L/min") for flow in leaky.leakage_flows.tolist()],
        "level": level_names(best),
        "delta_matched_percent": deltas,
    }
    return {
        "sealed_alarms": _records(sealed, [*map(alarmed, standings)]),
        "best_level_matched": _records(leaky, [leads | ranked(standings[0]), *map(ranked, standings[1:])]),
    }


def _records(table: RunTable, views: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """A record for each run: what holds as configured, and settled."""
    columns: dict[str, Any] = {
        "bulk_modulus_MPa": [convert(each, "MPa") for each in table[names.BULK_MODULUS].tolist()]
    }
    columns |= views[0]
    if len(views) > 1:
        columns["settled"] = [*Table.of(views[1])]
    return [*Table.of(columns | ({"labels": table.labels} if table.label_names else {}))]
