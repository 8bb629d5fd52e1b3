"""The sections of the scenarios study: how often each claim holds, which values carry it; controls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from hydrofdi.config.shown_values import shown_value
from hydrofdi.papers.maddahi2015.claims import CLAIMS
from hydrofdi.papers.maddahi2015.scenarios import CLAIM_SETS, CORE, ScenarioStudy, ValueShare
from hydrofdi.papers.maddahi2015.standings import Mask
from hydrofdi.report.table import Block, Column, Table, group_breaks
from hydrofdi.report.wording import joined, modulus_text, share_text
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE

_FOURTH = ("C4",)


def scenario_blocks(study: ScenarioStudy) -> tuple[Block, Block]:
    """How many scenarios are feasible and reproduce each claim, and which values carry that; the controls."""
    return (
        Block(
            "scenarios",
            "Scenarios: how much depends on what is not known",
            tuple(_sentences(study)),
            (_claims_table(study), _values_table(study)),
            ("scenarios",),
        ),
        Block(
            "scenarios-controls",
            "Controls over the scenarios",
            (),
            (_alarms_table(study),),
        ),
    )


def _sentences(study: ScenarioStudy) -> Iterator[str]:
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without results: {reasons}" if reasons else ""
    n_feasible = int(study.feasible.sum())
    yield f"{n_feasible:,} of {counted(len(study.outcomes), 'different scenario')} are feasible{rest}."


def _counts(name: str, values: Sequence[int | None]) -> Column:
    """A column of counts; holes where claims are open."""
    return Column(name, values, text=lambda count: HOLE if count is None else f"{count:,}")


def _share(study: ScenarioStudy, outcomes: Mask, members: Mask) -> str:
    return share_text(study.share(outcomes, members), with_interval=study.is_drawn)


def _claims_table(study: ScenarioStudy) -> Table:
    sets, sentences = list(CLAIM_SETS.values()), {claim.id: claim.sentence for claim in CLAIMS}
    is_open = list(map(study.is_open, sets))

    def known(of: Callable[[Sequence[str]], Any]) -> list[Any]:
        return [None if unknown else of(claims) for claims, unknown in zip(sets, is_open, strict=True)]

    def kept(claims: Sequence[str]) -> str:
        phases = study.configured.phases_held(claims)[study.reproducing(claims)]
        return f"{float(np.median(phases)):g} of {study.configured.n_phase}" if phases.size else HOLE

    shares = known(lambda claims: _share(study, study.reproducing(claims), study.decided(claims)))
    is_undecided = any((study.decided(claims) != study.feasible).any() for claims in sets)
    notes = [
        "Scenarios and share: at the configured start phase. Phases kept: in how many it holds, median over"
        " the scenarios that reproduce it at that phase.",
        "Intervals: 95 %, Wilson's, for dependent scenarios of one draw." if study.is_drawn else "",
        "Shares: of the feasible scenarios that decide a claim; –: none does." if is_undecided else "",
    ]
    return Table(
        (
            Column("Claim", [*CLAIM_SETS], is_text=True),
            Column("Sentence", [sentences.get(name, "all of them") for name in CLAIM_SETS], is_text=True),
            _counts("Scenarios", [study.count(claims, study.feasible) for claims in sets]),
            Column("Share", [each or HOLE for each in shares]),
            _counts("In all phases", [study.count_always(claims) for claims in sets]),
            Column("Phases kept", [each or HOLE for each in known(kept)]),
            _counts("Settled", known(study.count_settled)),
        ),
        "Scenarios that reproduce the claims",
        "scenarios-claims",
        (" ".join(filter(None, notes)),),
        (len(CLAIMS),),
    )


def _values_table(study: ScenarioStudy) -> Table:
    found = study.value_shares
    breaks = group_breaks([value.parameters for value in found])
    names = [", ".join(v.parameters) if k in (0, *breaks) else "" for k, v in enumerate(found)]
    columns = [
        Column("Parameter", names, is_text=True),
        Column("Value", list(map(value_text, found)), is_text=True),
        _counts("Scenarios", [int(value.members.sum()) for value in found]),
        _counts("Feasible", [int((value.members & study.feasible).sum()) for value in found]),
    ]
    for name in ("C1–C4", "C1–C6"):
        claims = CLAIM_SETS[name]
        columns.append(_counts(name, [study.count(claims, value.members) for value in found]))
        held, decided = study.reproducing(claims), study.decided(claims)
        shares = [
            HOLE if study.is_open(claims) else _share(study, held, value.members & decided) for value in found
        ]
        columns.append(Column("Share", shares))
    note = "Shares: of the feasible scenarios with this value. Ranges are fifths of the scenarios."
    return Table(tuple(columns), "Which values decide it", "scenarios-values", (note,), breaks)


def value_text(value: ValueShare) -> str:
    """The value or range, with its unit."""
    if value.is_range:
        return shown_value(value.parameters[0], {"uniform": value.values})
    return ", ".join(map(shown_value, value.parameters, value.values))


def _groups(study: ScenarioStudy) -> dict[str, Mask]:
    """Name → scenarios that the controls are counted over."""
    groups = {"all feasible": study.feasible}
    if study.doubts:
        groups["all runs are ok"] = study.sound
    if not study.is_open(_FOURTH):
        fourth = study.reproducing(_FOURTH)
        groups |= {"C4 holds": fourth, "C4 fails": study.decided(_FOURTH) & ~fourth}
    if not study.is_open(CORE):
        groups["C1–C4 hold"] = study.reproducing(CORE)
    return groups


def _alarms_table(study: ScenarioStudy) -> Table:
    groups = _groups(study)
    single = study.configured.alarms(study.configured.shown).T
    moduli = [modulus_text(study.grid.bulk_moduli[b]) for b in study.grid.raised]
    outcomes = list(zip(moduli, single, strict=True))
    for lead, standing in zip(("At every EBM", "Settled: at every EBM"), study.standings, strict=False):
        everywhere, throughout = standing.alarms_everywhere.values()
        outcomes += [(lead, everywhere), (f"{lead} and phase", throughout)]
    return Table(
        (
            Column("Scenarios", [*groups], is_text=True),
            _counts("Number", [int(members.sum()) for members in groups.values()]),
            *(
                Column(name, [_share(study, each, members) for members in groups.values()])
                for name, each in outcomes
            ),
        ),
        "The d3 rule on the sealed actuator: share of scenarios with an alarm",
        "scenarios-alarms",
    )
