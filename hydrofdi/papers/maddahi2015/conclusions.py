"""Claims: which sentences of the paper an experiment reproduces, by how much, and what survives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hydrofdi.papers.maddahi2015.claims import ClaimResult
from hydrofdi.papers.maddahi2015.standings import Outcome, points
from hydrofdi.report.table import Block, Column, Table, group_breaks, plain
from hydrofdi.report.wording import joined
from hydrofdi.settings.readable import HOLE

if TYPE_CHECKING:
    from hydrofdi.papers.maddahi2015.report import StudyReport

_SPREAD = ("mean", "least", "largest")
_ONE_PHASE = (
    "Only one start phase was measured. The decimated transform depends on it, so this is not a finding yet: "
    " set wavelet: {phase: all}."
)
_UNSETTLED = (
    "No run has settled features: no record holds two whole periods that agree. Lengthen record.duration."
)


def claim_record(study: StudyReport, result: ClaimResult) -> dict[str, Any]:
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


def claims_block(study: StudyReport) -> Block:
    """All claims with their margins; one sentence if there is no grid."""
    title = "Claims: the paper's sentences as checks"
    if study.grid.lack:
        return Block("claims", title, (study.grid.lack, *required(study)))
    return Block("claims", title, required(study), (_claims_table(study),))


def required(study: StudyReport) -> tuple[str, ...]:
    """Whether the claims that the file lists hold, in all feasible scenarios of an ensemble."""
    if not study.guarded:
        return ()
    lost = joined([each.claim.id for each in study.guarded if not each.reproduced])
    held = f"not so, or open, for {lost}" if lost else "all of them hold, at the configured start phase"
    return (f"The experiment file requires {joined([each.claim.id for each in study.guarded])}: {held}.",)


def _claims_table(study: StudyReport) -> Table:
    note = (
        "At the configured start phase. Margin: how far one δ behind a claim could move before its result"
        " turns; negative if it does not hold. If it is a difference of two δ, both may move, each by half of"
        " it. –: open, cannot be decided (a run is missing, or the actuator does not move)."
    )
    records = [claim_record(study, each) for each in study.claims]
    nested = ("checks", "phases", "settled")
    return Table.of_records(plain(records), nested, title="Claims", key="claims", notes=(note,))


def standing_blocks(study: StudyReport) -> tuple[Block, Block]:
    """Which claims and sealed alarms survive every start phase, as configured and settled; their numbers."""
    n_phase, said = study.standings[0].n_phase, [_ONE_PHASE]
    named = [] if study.grid.lack else [(each.name, each) for each in study.claim_outcomes]
    named += [(f"the d3 alarm on the sealed actuator at {each.name}", each) for each in study.alarm_outcomes]
    if n_phase > 1:
        said = [line for standing in study.standings for line in _survivors(named, standing.title)]
    said += [_UNSETTLED] if len(study.standings) == 1 else []
    outcomes = [each for _, each in named]
    table = Table(
        (
            Column("Records", [each.records for each in outcomes], is_text=True),
            Column("What", [name for name, _ in named], is_text=True),
            Column(
                "Phases in which it holds",
                [f"{each.held} of {each.of}" if each.of else HOLE for each in outcomes],
                is_text=True,
                strong=[k for k, each in enumerate(outcomes) if 0 < each.held < each.of],
            ),
            *(points(name.title(), [each.spread[name] for each in outcomes]) for name in _SPREAD),
            points("Number", [each.number for each in outcomes]),
        ),
        "Margins of the claims and δd3 of the sealed alarms over the start phases",
        "phases-numbers",
        (
            "Margins in percentage points, δd3 in percent. Phase p: the record from its sample p on; phases"
            " of settled records repeat if a period has fewer samples. Number: at the configured phase; of"
            " settled records that of the undecimated transform, free of boundaries, which holds all phases.",
        ),
        group_breaks([each.records for each in outcomes]),
    )
    title = "Claims and the sealed alarm over the start phases"
    return (
        Block("standing", "What survives: start phases and settled records", tuple(said)),
        Block("phases", title, (), (table,), ("phases",) if n_phase > 1 else ()),
    )


def _survivors(named: list[tuple[str, Outcome]], records: str) -> Iterator[str]:
    own = [(name, each.held, each.of) for name, each in named if each.of and each.records == records]
    found = {
        "Hold at every start phase": [name for name, held, of in own if held == of],
        "Depend on the start phase": [f"{name} ({held} of {of})" for name, held, of in own if 0 < held < of],
        "Hold at no start phase": [name for name, held, _ in own if not held],
    }
    for where, which in found.items():
        if which:
            yield f"{where} ({records}): {joined(which)}."
