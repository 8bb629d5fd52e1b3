"""The scenarios study: how often each claim holds, at which phases, and which values carry it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.shown_values import shown_value
from hydrofdi.papers.maddahi2015.claims import CLAIMS
from hydrofdi.papers.maddahi2015.scenarios.study import CORE, Mask, ScenarioStudy
from hydrofdi.papers.maddahi2015.scenarios.values import ValueShare
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.wording import joined, share_text
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE


def scenarios_block(study: ScenarioStudy) -> Block:
    """How many scenarios are feasible, how many reproduce each claim, and which values carry that."""
    return Block(
        "scenarios",
        "Scenarios: how much depends on what is not known",
        (_feasible_sentence(study), *_doubt_sentences(study), _together_sentence(study)),
        (_claims_sheet(study), _values_sheet(study)),
        ("scenarios",),
    )


def _doubt_sentences(study: ScenarioStudy) -> list[str]:
    parts = [f"{word} in {int((mask & study.feasible).sum()):,}" for word, mask in study.doubts.items()]
    if not parts:
        return []
    return [
        f"Feasible scenarios with a run whose verdict is not ok: {joined(parts)};"
        f" {int(study.sound.sum()):,} have none."
    ]


def _feasible_sentence(study: ScenarioStudy) -> str:
    feasible = int(study.feasible.sum())
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without results: {reasons}" if reasons else ""
    return f"{feasible:,} of {counted(study.n_scenario, 'different scenario')} are feasible{rest}."


def _together_sentence(study: ScenarioStudy) -> str:
    feasible = int(study.feasible.sum())
    parts = [
        f"{name} {'open' if study.is_open(claims) else f'in {int(study.reproducing(claims).sum())}'}"
        for name, claims in study.claim_sets.items()
        if len(claims) > 1
    ]
    return f"Of the {counted(feasible, 'feasible scenario')}, several claims hold together: {joined(parts)}."


def _claims_sheet(study: ScenarioStudy) -> Sheet:
    sentences = {claim.id: claim.sentence for claim in CLAIMS}
    rows = []
    for name, claims in study.claim_sets.items():
        sentence = sentences.get(name, "all of them")
        counts = _count_cells(study, claims, study.feasible)
        rows.append((Cell(name), Cell(sentence), *counts, *_phase_cells(study, claims)))
    is_undecided = any((study.decided(c) != study.feasible).any() for c in study.claim_sets.values())
    notes = [
        "Scenarios and share: at the configured start phase. Phases kept: in how many it holds, median over"
        " the scenarios that reproduce it at that phase.",
        "Intervals: 95 %, Wilson's, for dependent scenarios of one draw." if study.is_drawn else "",
        "Shares: of the feasible scenarios that decide a claim; –: none does." if is_undecided else "",
    ]
    return Sheet(
        "scenarios-claims",
        "Scenarios that reproduce the claims",
        ("Claim", "Sentence", "Scenarios", "Share", "In all phases", "Phases kept", "Settled"),
        tuple(rows),
        breaks=(len(CLAIMS),),
        text_columns=(0, 1),
        note=" ".join(note for note in notes if note),
    )


def _phase_cells(study: ScenarioStudy, claims: tuple[str, ...]) -> tuple[Cell, Cell, Cell]:
    """In how many scenarios claims hold at all phases, in how many phases they are kept, and settled."""
    if study.is_open(claims):
        return Cell(HOLE), Cell(HOLE), Cell(HOLE)
    n_phase, phases = study.configured.n_phase, study.configured.phases_held(claims)
    here = study.reproducing(claims)
    kept = f"{float(np.median(phases[here])):g} of {n_phase}" if here.any() else HOLE
    always = int((study.feasible & (phases == n_phase)).sum())
    settled = (
        HOLE if study.settled is None else f"{int((study.feasible & study.settled.held(claims)).sum()):,}"
    )
    return Cell(f"{always:,}", value=always), Cell(kept), Cell(settled)


def _count_cells(study: ScenarioStudy, claims: tuple[str, ...], members: Mask) -> tuple[Cell, Cell]:
    """How many of these scenarios reproduce claims, and which share; holes if the claims are open."""
    if study.is_open(claims):
        return Cell(HOLE), Cell(HOLE)
    held = study.reproducing(claims)
    count = int((members & held).sum())
    return Cell(f"{count:,}", value=count), _share_cell(study, held, members & study.decided(claims))


def _share_cell(study: ScenarioStudy, outcomes: NDArray[np.bool_], members: Mask) -> Cell:
    """A share among some scenarios, with its interval where scenarios are drawn."""
    found = study.share(outcomes, members)
    return Cell(share_text(found, with_interval=study.is_drawn), value=100.0 * found.value)


def _values_sheet(study: ScenarioStudy) -> Sheet:
    rows = [_value_cells(study, value) for value in study.value_shares]
    breaks = group_breaks([value.parameters for value in study.value_shares])
    rows = [row if position in (0, *breaks) else (Cell(""), *row[1:]) for position, row in enumerate(rows)]
    return Sheet(
        "scenarios-values",
        "Which values decide it",
        ("Parameter", "Value", "Scenarios", "Feasible", "C1–C4", "Share", "C1–C6", "Share"),
        tuple(rows),
        breaks=breaks,
        text_columns=(0, 1),
        note="Shares: of the feasible scenarios with this value. Ranges are fifths of the scenarios.",
    )


def _value_cells(study: ScenarioStudy, value: ValueShare) -> tuple[Cell, ...]:
    members = value.members
    feasible = int((members & study.feasible).sum())
    return (
        Cell(", ".join(value.parameters)),
        Cell(value_text(value)),
        Cell(f"{int(members.sum()):,}"),
        Cell(f"{feasible:,}", value=feasible),
        *_count_cells(study, CORE, members),
        *_count_cells(study, study.claim_sets["C1–C6"], members),
    )


def value_text(value: ValueShare) -> str:
    """The value or range, with its unit."""
    if value.is_range:
        return shown_value(value.parameters[0], {"uniform": value.values})
    return ", ".join(map(shown_value, value.parameters, value.values))
