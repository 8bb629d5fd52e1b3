"""Verdicts: which sentences of the paper an experiment reproduces, and by how much."""

from __future__ import annotations

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.claims import CheckResult, Verdict
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.wording import counted, joined, labels_text, mode_name, signed


def verdicts_block(analysis: Analysis) -> Block:
    """All claims with their margins, and every check behind them; one sentence where there is no grid."""
    title = "Verdicts: the paper's sentences as checks"
    if analysis.grid.lack:
        guarded = (_guarded_sentence(analysis),) if analysis.guarded else ()
        return Block("claims", title, (analysis.grid.lack, *guarded))
    return Block(
        "claims",
        title,
        tuple(_sentences(analysis)),
        (_claims_sheet(analysis.verdicts), _checks_sheet(analysis)),
    )


def word(outcome: bool | None) -> str:
    """An outcome in words."""
    return {True: "reproduced", False: "not reproduced", None: "open"}[outcome]


def _sentences(analysis: Analysis) -> list[str]:
    groups = {
        outcome: [v.claim.id for v in analysis.verdicts if v.reproduced is outcome]
        for outcome in (True, False, None)
    }
    sentences = [
        f"{joined(ids)}: {word(outcome)}, at the configured phase." for outcome, ids in groups.items() if ids
    ]
    decided = [v for v in analysis.verdicts if v.reproduced]
    if decided:
        least = min(decided, key=lambda verdict: verdict.margin)
        sentences.append(
            f"The least margin of what is reproduced is {least.margin:.2f} percentage points"
            f" ({least.claim.id})."
        )
    if analysis.guarded:
        sentences.append(_guarded_sentence(analysis))
    return sentences


def guarded_block(analysis: Analysis) -> Block | None:
    """Whether the claims that an ensemble's file lists hold in all feasible readings; None if it has none."""
    if not analysis.guarded:
        return None
    return Block("guarded", "Required claims, over all feasible readings", (_guarded_sentence(analysis),))


def _guarded_sentence(analysis: Analysis) -> str:
    broken = [v.claim.id for v in analysis.guarded if v.reproduced is False]
    undecided = [v.claim.id for v in analysis.guarded if v.reproduced is None]
    parts = [f"not so for {joined(broken)}"] if broken else []
    parts += [f"open for {joined(undecided)}"] if undecided else []
    held = "; ".join(parts) or "all of them hold"
    required = joined([v.claim.id for v in analysis.guarded])
    return f"The experiment file requires {required}: {held}."


def _claims_sheet(verdicts: tuple[Verdict, ...]) -> Sheet:
    return Sheet(
        key="claims",
        title="Claims",
        headers=(
            "Claim",
            "Sentence",
            "Verdict",
            "Checks held",
            "Margin [points]",
            "Each δ may move [points]",
        ),
        rows=tuple(_claim_cells(verdict) for verdict in verdicts),
        text_columns=(0, 1, 2),
        note="At the configured start phase. Margin: how far one δ behind a claim could move before its"
        " verdict turns; negative where it does not hold. Where it is a difference of two δ, both may move,"
        " each by half of it. Open: a run is missing or failed, its healthy run stands still, or there is no"
        " such mode.",
    )


def _claim_cells(verdict: Verdict) -> tuple[Cell, ...]:
    held = sum(check.holds is True for check in verdict.checks)
    return (
        Cell(verdict.claim.id),
        Cell(verdict.claim.sentence),
        Cell(word(verdict.reproduced), verdict.reproduced is False, word(verdict.reproduced)),
        Cell(f"{held} of {len(verdict.checks)}"),
        Cell(signed(verdict.margin, 2), value=verdict.margin),
        Cell(signed(verdict.allowance, 2), value=verdict.allowance),
    )


def _checks_sheet(analysis: Analysis) -> Sheet:
    checks = [(verdict, check) for verdict in analysis.verdicts for check in verdict.checks]
    return Sheet(
        key="checks",
        title="Checks",
        headers=("Claim", "Rule", "Modes", "Holds", "Margin [points]", "Runs"),
        rows=tuple(_check_cells(analysis, verdict, check) for verdict, check in checks),
        breaks=group_breaks([verdict.claim.id for verdict, _ in checks]),
        text_columns=(0, 1, 2, 3, 5),
        note="Runs: the healthy run that δ is taken against, then the leaky ones.",
    )


def _check_cells(analysis: Analysis, verdict: Verdict, check: CheckResult) -> tuple[Cell, ...]:
    holds = {True: "yes", False: "no", None: "open"}[check.holds]
    return (
        Cell(verdict.claim.id),
        Cell(verdict.claim.rule),
        Cell(modes_text(analysis, check)),
        Cell(holds, check.holds is False),
        Cell(signed(check.margin, 2), value=check.margin),
        Cell(" ".join(run_id[:6] for run_id in check.run_ids)),
    )


def modes_text(analysis: Analysis, check: CheckResult) -> str:
    """The modes that a check looks at."""
    grid = analysis.grid
    labels = labels_text(grid.readings[check.reading])
    if len(check.modes) > 3 and len(check.modes) == grid.n_mode:
        text = f"all {counted(len(check.modes), 'leaky mode')}"
    else:
        text = ", ".join(mode_name(grid.leakage_flows[q], grid.bulk_moduli[b]) for q, b in check.modes)
    return f"{text} ({labels})" if labels else text
