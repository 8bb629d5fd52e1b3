"""The readings study: how often each claim holds, what carries it, and what the controls say then."""

from __future__ import annotations

import numpy as np

from hydrofdi.report.claims import CLAIMS
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.readings import CORE, Mask, ReadingsStudy, ValueShare
from hydrofdi.report.table import label_header, level_name
from hydrofdi.report.wording import HOLE, counted, joined, megapascal, mode_name, plain, share


def readings_block(study: ReadingsStudy) -> Block:
    """How many readings are feasible, how many reproduce each claim, and which values carry that."""
    return Block(
        "readings",
        "Readings: how much hangs on what is not known",
        (_feasible_sentence(study), _together_sentence(study)),
        (_claims_sheet(study), _values_sheet(study)),
        ("readings",),
    )


def readings_controls_block(study: ReadingsStudy) -> Block:
    """The controls over the readings that reproduce C1–C4."""
    core = study.reproducing(CORE)
    none = (
        "C1–C4 are open: no reading tests all."
        if study.is_open(CORE)
        else "No feasible reading reproduces C1–C4."
    )
    sentences = _control_sentences(study, core) if core.any() else (none,)
    sheets = (_alarms_sheet(study, core), _best_levels_sheet(study, core)) if core.any() else ()
    return Block("readings-controls", "Controls over the readings that reproduce C1–C4", sentences, sheets)


def _feasible_sentence(study: ReadingsStudy) -> str:
    feasible = int(study.feasible.sum())
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without numbers: {reasons}" if reasons else ""
    return f"{feasible} of {counted(study.n_reading, 'different reading')} are feasible{rest}."


def _together_sentence(study: ReadingsStudy) -> str:
    feasible = int(study.feasible.sum())
    parts = [
        f"{name} {'open' if study.is_open(claims) else f'in {int(study.reproducing(claims).sum())}'}"
        for name, claims in study.claim_sets.items()
        if len(claims) > 1
    ]
    return f"Of the {counted(feasible, 'feasible reading')}, several claims hold together: {joined(parts)}."


def _claims_sheet(study: ReadingsStudy) -> Sheet:
    sentences = {claim.id: claim.sentence for claim in CLAIMS}
    rows = []
    for name, claims in study.claim_sets.items():
        sentence = sentences.get(name, "all of them")
        rows.append((Cell(name), Cell(sentence), *_count_cells(study, claims, study.feasible)))
    is_undecided = any((study.decided(c) != study.feasible).any() for c in study.claim_sets.values())
    return Sheet(
        "readings-claims",
        "Readings that reproduce the claims",
        ("Claim", "Sentence", "Readings", "Share of the feasible"),
        tuple(rows),
        breaks=(len(CLAIMS),),
        text_columns=(0, 1),
        note="Shares: of the feasible readings that decide a claim; –: none does." if is_undecided else "",
    )


def _count_cells(study: ReadingsStudy, claims: tuple[str, ...], members: Mask) -> tuple[Cell, Cell]:
    """How many of these readings reproduce claims, and which share; holes where the claims are open."""
    if study.is_open(claims):
        return Cell(HOLE), Cell(HOLE)
    count = int((members & study.reproducing(claims)).sum())
    return Cell(f"{count:,}", value=count), Cell(share(count, int((members & study.decided(claims)).sum())))


def _values_sheet(study: ReadingsStudy) -> Sheet:
    rows = [_value_cells(study, value) for value in study.value_shares]
    breaks = group_breaks([value.parameters for value in study.value_shares])
    rows = [row if position in (0, *breaks) else (Cell(""), *row[1:]) for position, row in enumerate(rows)]
    return Sheet(
        "readings-values",
        "Which values carry it",
        ("Parameter", "Value", "Readings", "Feasible", "C1–C4", "Share", "C1–C6", "Share"),
        tuple(rows),
        breaks=breaks,
        text_columns=(0, 1),
        note="Shares: of the feasible readings with this value. Ranges are fifths of the readings.",
    )


def _value_cells(study: ReadingsStudy, value: ValueShare) -> tuple[Cell, ...]:
    members = value.members
    feasible = int((members & study.feasible).sum())
    return (
        Cell(", ".join(label_header(name) for name in value.parameters)),
        Cell(value_text(value)),
        Cell(f"{int(members.sum()):,}"),
        Cell(f"{feasible:,}", value=feasible),
        *_count_cells(study, CORE, members),
        *_count_cells(study, study.claim_sets["C1–C6"], members),
    )


def value_text(value: ValueShare) -> str:
    """The value or range in SI."""
    if value.is_range:
        return " … ".join(f"{end:.3g}" for end in value.values)
    return ", ".join(plain(part) for part in value.values)


def _control_sentences(study: ReadingsStudy, core: Mask) -> tuple[str, ...]:
    total = int(core.sum())
    alarms = study.alarms[core]
    moduli = [f"{megapascal(study.grid.bulk_moduli[b])} MPa" for b in study.grid.raised]
    parts = [f"at {beta} in {int(alarms[:, k].sum())}" for k, beta in enumerate(moduli)]
    always, never = int(alarms.all(axis=1).sum()), int((~alarms.any(axis=1)).sum())
    best = study.best_levels[core]
    levels, counts = np.unique(best, return_counts=True)
    shares = [
        f"{level_name(int(level)) if level >= 0 else 'none'} in {share(int(count), best.size)}"
        for level, count in zip(levels, counts, strict=True)
    ]
    return (
        f"Where C1–C4 hold ({counted(total, 'reading')}), the d3 rule alarms on the sealed actuator"
        f" {joined(parts)}; at every EBM above normal in {always} ({share(always, total)}),"
        f" at none in {never}.",
        f"Under the matched baseline the best level of their leaky modes is {joined(shares)} of the modes.",
    )


def _alarms_sheet(study: ReadingsStudy, core: Mask) -> Sheet:
    rows = []
    for k, beta in enumerate(study.grid.raised):
        count, anywhere = int(study.alarms[core][:, k].sum()), int(study.alarms[study.feasible][:, k].sum())
        rows.append(
            (
                Cell(megapascal(study.grid.bulk_moduli[beta])),
                Cell(f"{count:,}", value=count),
                Cell(share(count, int(core.sum()))),
                Cell(f"{anywhere:,}", value=anywhere),
                Cell(share(anywhere, int(study.feasible.sum()))),
            )
        )
    headers = ("EBM [MPa]", "Alarms, C1–C4 hold", "Share", "Alarms, all feasible", "Share")
    return Sheet("readings-alarms", "The d3 rule on the sealed actuator", headers, tuple(rows))


def _best_levels_sheet(study: ReadingsStudy, core: Mask) -> Sheet:
    grid = study.grid
    rows = []
    for column, (q, b) in enumerate(grid.modes()):
        best = study.best_levels[core][:, column]
        counts = [int((best == level).sum()) for level in (*range(grid.n_level), -1)]
        cells = [Cell(share(count, best.size), count == max(counts), count) for count in counts]
        rows.append((Cell(mode_name(grid.leakage_flows[q], grid.bulk_moduli[b])), *cells))
    headers = ("Mode", *(f"d{level}" for level in range(1, grid.n_level + 1)), "none")
    return Sheet(
        "readings-best-levels",
        "The best level of each mode against the matched baseline",
        headers,
        tuple(rows),
        breaks=group_breaks([q for q, _ in grid.modes()]),
        text_columns=(0,),
    )
