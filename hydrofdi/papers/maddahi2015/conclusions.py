"""Claims: which sentences of the paper an experiment reproduces, by how much, and what survives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from hydrofdi.papers.maddahi2015.claims import ClaimResult
from hydrofdi.papers.maddahi2015.standings import phases_table, points
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.quality.doubts import samples_per_period
from hydrofdi.report.table import Block, Column, Table
from hydrofdi.report.wording import joined

_WORDS = {True: "reproduced", False: "not reproduced", None: "open"}
_ONE_PHASE = (
    "Only one start phase was measured. The decimated transform depends on it, so this is not a finding yet: "
    " set wavelet: {phase: all}."
)
_UNSETTLED = (
    "No run has settled features: no record holds two whole periods that agree. Lengthen record.duration."
)


def claim_record(study: Study, result: ClaimResult) -> dict[str, Any]:
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
        "checks": [*study.checks(result)] if study.scenarios is None else [],
        "phases": configured.phases("margin_percentage_points"),
    }
    for outcome in settled:
        record["settled"] = {
            "reproduced": None if math.isnan(outcome.number) else outcome.number > 0.0,
            "margin_percentage_points": outcome.number,
            "phases": outcome.phases("margin_percentage_points"),
        }
    return record


def claims_block(study: Study) -> Block:
    """All claims with their margins; one sentence if there is no grid."""
    title, required = "Claims: the paper's sentences as checks", tuple(_required(study))
    if study.grid.lack:
        return Block("claims", title, (study.grid.lack, *required))
    return Block("claims", title, (*_sentences(study), *required), (_claims_table(study),))


def _sentences(study: Study) -> Iterator[str]:
    for outcome, word in _WORDS.items():
        if ids := [each.claim.id for each in study.claims if each.reproduced is outcome]:
            yield f"{joined(ids)}: {word}, at the configured phase."


def guarded_block(study: Study) -> Block | None:
    """Whether the claims that an ensemble's file lists hold in all feasible scenarios; None without any."""
    said = tuple(_required(study))
    return Block("guarded", "Required claims, over all feasible scenarios", said) if said else None


def _required(study: Study) -> Iterator[str]:
    """Whether the claims that the file lists hold."""
    words = {False: "not so for", None: "open for"}
    parts = [
        f"{word} {joined(ids)}"
        for outcome, word in words.items()
        if (ids := [each.claim.id for each in study.guarded if each.reproduced is outcome])
    ]
    held = "; ".join(parts) or "all of them hold, at the configured start phase"
    if study.guarded:
        yield f"The experiment file requires {joined([each.claim.id for each in study.guarded])}: {held}."


def _claims_table(study: Study) -> Table:
    results = study.claims
    checks = [[check["holds"] for check in study.checks(result)] for result in results]
    return Table(
        (
            Column("Claim", [each.claim.id for each in results], is_text=True),
            Column("Sentence", [each.claim.sentence for each in results], is_text=True),
            Column("Rule", [each.claim.rule for each in results], is_text=True),
            Column(
                "Result",
                [_WORDS[each.reproduced] for each in results],
                is_text=True,
                strong=[k for k, each in enumerate(results) if each.reproduced is False],
            ),
            Column("Checks held", [f"{each.count(True)} of {len(each)}" for each in checks]),
            points("Margin [points]", [each.margin for each in results]),
            points("Each δ may move [points]", [each.allowance for each in results]),
        ),
        "Claims",
        "claims",
        (
            "At the configured start phase. Margin: how far one δ behind a claim could move before its"
            " result turns; negative if it does not hold. If it is a difference of two δ, both may move,"
            " each by half of it. Open: cannot be decided (a run is missing, or the actuator does not move).",
        ),
    )


def standing_blocks(study: Study) -> tuple[Block, Block]:
    """Which claims and sealed alarms survive every start phase, as configured and settled; their numbers."""
    n_phase, said = study.standings[0].n_phase, [_ONE_PHASE]
    if n_phase > 1:
        said = [line for standing in study.standings for line in _survivors(study, standing.title)]
    said += [_UNSETTLED] if len(study.standings) == 1 else []
    claims_table = phases_table(
        "Margins of the claims over the start phases [percentage points]",
        "claims-phases",
        "Claim",
        "Margin",
        study.claim_outcomes,
        "Phase p: the record from its sample p on. Margin: at the configured phase; of settled records"
        " that of the undecimated transform, which is free of boundaries and holds all phases.",
    )
    alarms_table = phases_table(
        "δd3 [%] of the sealed actuator over the start phases, and in how many the d3 rule alarms",
        "sealed-alarms-phases",
        "Sealed at",
        "δd3",
        study.alarm_outcomes,
    )
    return (
        Block("standing", "What survives: start phases and settled records", tuple(said)),
        Block(
            "phases",
            "Claims and the sealed alarm over the start phases",
            tuple(_repeated_phases(study)),
            (*([] if study.grid.lack else [claims_table]), alarms_table),
            ("phases",) if n_phase > 1 else (),
        ),
    )


def _survivors(study: Study, records: str) -> Iterator[str]:
    named = [(each.name, each) for each in study.claim_outcomes]
    named += [(f"the d3 alarm on the sealed actuator at {each.name}", each) for each in study.alarm_outcomes]
    decided = {name: each for name, each in named if each.of and each.records == records}
    always = [name for name, each in decided.items() if each.held == each.of]
    never = [name for name, each in decided.items() if not each.held]
    turning = [
        f"{name} ({each.held} of {each.of})" for name, each in decided.items() if 0 < each.held < each.of
    ]
    for where, which in (
        ("Hold at every start phase", always),
        ("Depend on the start phase", turning),
        ("Hold at no start phase", never),
    ):
        if which:
            yield f"{where} ({records}): {joined(which)}."


def _repeated_phases(study: Study) -> Iterator[str]:
    """How many different phases a settled record has: its grid repeats from period to period."""
    period, n_phase = samples_per_period(study.data.experiment.nominal_parameters), study.standings[0].n_phase
    different = math.gcd(period, n_phase) if period else n_phase
    if different < n_phase:
        yield (
            f"A period holds {period:,} samples: the {n_phase} phases of a settled record are {different}"
            f" different ones, {n_phase // different} times each."
        )
