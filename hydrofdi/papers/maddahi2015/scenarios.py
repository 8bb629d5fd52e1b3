"""What the scenarios of an ensemble come to, in data and sections: how much depends on what is not known."""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrofdi.config.shown_values import shown_value
from hydrofdi.papers.maddahi2015.claims import CLAIMS, Mask
from hydrofdi.papers.maddahi2015.study import CLAIM_SETS, CORE, ScenarioStudy, ValueShare
from hydrofdi.report.table import Block, Table, group_breaks
from hydrofdi.report.wording import joined, modulus_text, share_text
from hydrofdi.settings.messages import counted


def scenarios_record(study: ScenarioStudy) -> dict[str, Any]:
    """Counts over all scenarios, and each scenario by itself, for programs."""
    sets, feasible = CLAIM_SETS.items(), study.feasible
    groups = {"feasible": feasible, "C1–C4": study.reproducing(CORE), "C4": study.reproducing(("C4",))}
    settled = {name: study.count_settled(claims) for name, claims in sets}
    everywhere = study.configured.alarms_everywhere.items()
    return {
        "scenarios": len(study.outcomes),
        "feasible": int(feasible.sum()),
        "infeasible": study.obstacles,
        "reproducing": {name: study.count(claims, feasible) for name, claims in sets},
        "values": [
            {
                "parameters": list(value.parameters),
                "range" if value.is_range else "values": list(value.values),
                "scenarios": int(value.members.sum()),
                "feasible": int((value.members & feasible).sum()),
                "reproducing": {name: study.count(claims, value.members) for name, claims in sets},
            }
            for value in study.value_shares
        ],
        "phases": study.configured.n_phase,
        "reproducing_in_all_phases": {name: study.count_always(claims) for name, claims in sets},
        "reproducing_settled": settled if len(study.standings) > 1 else None,
        "doubtful": {word: int((mask & feasible).sum()) for word, mask in study.doubts.items()},
        "sealed_alarms": {
            name: {key: _share_record(study, outcomes, members) for key, outcomes in everywhere}
            for name, members in groups.items()
        },
        "best_level_d2_matched_above_normal": {
            name: _share_record(study, study.is_d2_best, members) for name, members in groups.items()
        },
        "members": _members(study),
    }


def _share_record(study: ScenarioStudy, outcomes: Mask, members: Mask) -> dict[str, Any]:
    found = study.share(outcomes, members)
    interval = [found.low, found.high] if study.is_drawn else None
    return {"count": found.count, "of": found.total, "interval_95": interval}


def _members(study: ScenarioStudy) -> list[dict[str, Any]]:
    margins = {claim: margin.tolist() for claim, margin in study.configured.margins.items()}
    held = {claim: study.configured.phases_held((claim,)).tolist() for claim in margins}
    alarms = study.configured.alarms(study.configured.shown).tolist()
    return [
        {
            "values": study.grid.scenarios[k],
            "outcome": outcome,
            "margins_percentage_points": {
                claim: each[k] if outcome == "ok" else None for claim, each in margins.items()
            },
            "phases_held": {claim: each[k] if outcome == "ok" else None for claim, each in held.items()},
            "sealed_alarms": alarms[k] if outcome == "ok" else None,
        }
        for k, outcome in enumerate(study.outcomes)
    ]


def scenario_blocks(study: ScenarioStudy) -> tuple[Block, Block]:
    """How many scenarios are feasible and reproduce each claim, and which values carry that; the controls."""
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without results: {reasons}" if reasons else ""
    n_feasible, n_scenario = int(study.feasible.sum()), counted(len(study.outcomes), "different scenario")
    title, key = "Scenarios: how much depends on what is not known", "scenarios"
    said, tables = f"{n_feasible:,} of {n_scenario} are feasible{rest}.", (_claims(study), _values(study))
    return (
        Block(key, title, (said,), tables, (key,)),
        Block("scenarios-controls", "Controls over the scenarios", (), (_alarms(study),)),
    )


def _share(study: ScenarioStudy, outcomes: Mask, members: Mask) -> str:
    return share_text(study.share(outcomes, members), with_interval=study.is_drawn)


def _claims(study: ScenarioStudy) -> Table:
    rows, sentences = [], {claim.id: claim.sentence for claim in CLAIMS}
    for name, claims in CLAIM_SETS.items():
        held, is_open = study.reproducing(claims), study.is_open(claims)
        phases, n_phase = study.configured.phases_held(claims)[held], study.configured.n_phase
        rows.append(
            {
                "claim": name,
                "sentence": sentences.get(name, "all of them"),
                "scenarios": study.count(claims, study.feasible),
                "share": None if is_open else _share(study, held, study.decided(claims)),
                "in all phases": study.count_always(claims),
                "phases kept": f"{float(np.median(phases)):g} of {n_phase}" if held.any() else None,
                "settled": None if is_open else study.count_settled(claims),
            }
        )
    note = (
        "Scenarios and share: at the configured start phase, of the feasible scenarios that decide a claim;"
        " –: none does. Phases kept: in how many it holds, median over the scenarios that reproduce it."
        " Intervals, of random draws alone: 95 %, Wilson's, for dependent scenarios of one draw."
    )
    title = "Scenarios that reproduce the claims"
    return Table.of_records(rows, title=title, key="scenarios-claims", notes=(note,), breaks=(len(CLAIMS),))


def _values(study: ScenarioStudy) -> Table:
    rows = []
    for value in study.value_shares:
        row: dict[str, Any] = {
            "parameter": ", ".join(value.parameters),
            "value": value_text(value),
            "scenarios": int(value.members.sum()),
            "feasible": int((value.members & study.feasible).sum()),
        }
        for name in ("C1–C4", "C1–C6"):
            claims = CLAIM_SETS[name]
            decided = value.members & study.decided(claims)
            row[name] = study.count(claims, value.members)
            share = None if study.is_open(claims) else _share(study, study.reproducing(claims), decided)
            row[f"share of {name}"] = share
        rows.append(row)
    note = "Shares: of the feasible scenarios with this value. Ranges are fifths of the scenarios."
    breaks, title = group_breaks([row["parameter"] for row in rows]), "Which values decide it"
    return Table.of_records(rows, title=title, key="scenarios-values", notes=(note,), breaks=breaks)


def value_text(value: ValueShare) -> str:
    """The value or range, with its unit."""
    if value.is_range:
        return shown_value(value.parameters[0], {"uniform": value.values})
    return ", ".join(map(shown_value, value.parameters, value.values))


def _alarms(study: ScenarioStudy) -> Table:
    fourth = study.reproducing(("C4",))
    groups = {
        "all feasible": study.feasible,
        "C4 holds": fourth,
        "C4 fails": study.decided(("C4",)) & ~fourth,
        "C1–C4 hold": study.reproducing(CORE),
    }
    moduli = [modulus_text(study.grid.bulk_moduli[b]) for b in study.grid.raised]
    outcomes = dict(zip(moduli, study.configured.alarms(study.configured.shown).T, strict=True))
    for standing in study.standings:
        outcomes |= {f"{key}, {standing.title}": mask for key, mask in standing.alarms_everywhere.items()}
    rows = [
        {"scenarios": name, "number": int(members.sum())}
        | {title: _share(study, each, members) for title, each in outcomes.items()}
        for name, members in groups.items()
    ]
    title = "The d3 rule on the sealed actuator: share of scenarios with an alarm at an EBM, or at all"
    return Table.of_records(rows, title=title, key="scenarios-alarms")
