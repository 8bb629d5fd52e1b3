"""Claims: which sentences of the paper an experiment reproduces, and by how much."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015.claims import CheckResult, ClaimResult
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.wording import joined, labels_text, mode_name, signed
from hydrofdi.settings.counting import counted


def claims_block(study: Study) -> Block:
    """All claims with their margins; one sentence if there is no grid."""
    title = "Claims: the paper's sentences as checks"
    if study.grid.lack:
        guarded = (_guarded_sentence(study),) if study.guarded else ()
        return Block("claims", title, (study.grid.lack, *guarded))
    return Block("claims", title, tuple(_sentences(study)), (_claims_sheet(study.claims),))


def checks_block(study: Study) -> Block | None:
    """Every check behind the claims; None if there is no grid."""
    return (
        None if study.grid.lack else Block("checks", "Checks behind the claims", (), (_checks_sheet(study),))
    )


def word(outcome: bool | None) -> str:
    """An outcome in words."""
    return {True: "reproduced", False: "not reproduced", None: "open"}[outcome]


def _sentences(study: Study) -> list[str]:
    groups = {
        outcome: [v.claim.id for v in study.claims if v.reproduced is outcome]
        for outcome in (True, False, None)
    }
    sentences = [
        f"{joined(ids)}: {word(outcome)}, at the configured phase." for outcome, ids in groups.items() if ids
    ]
    decided = [v for v in study.claims if v.reproduced]
    if decided:
        least = min(decided, key=lambda result: result.margin)
        sentences.append(
            f"The smallest margin of what is reproduced is {least.margin:.2f} percentage points"
            f" ({least.claim.id})."
        )
    if study.guarded:
        sentences.append(_guarded_sentence(study))
    return sentences


def guarded_block(study: Study) -> Block | None:
    """Whether the claims that an ensemble's file lists hold in all feasible scenarios; None without any."""
    if not study.guarded:
        return None
    return Block("guarded", "Required claims, over all feasible scenarios", (_guarded_sentence(study),))


def _guarded_sentence(study: Study) -> str:
    broken = [v.claim.id for v in study.guarded if v.reproduced is False]
    undecided = [v.claim.id for v in study.guarded if v.reproduced is None]
    parts = [f"not so for {joined(broken)}"] if broken else []
    parts += [f"open for {joined(undecided)}"] if undecided else []
    held = "; ".join(parts) or "all of them hold, at the configured start phase"
    required = joined([v.claim.id for v in study.guarded])
    return f"The experiment file requires {required}: {held}."


def _claims_sheet(results: tuple[ClaimResult, ...]) -> Sheet:
    return Sheet(
        key="claims",
        title="Claims",
        headers=(
            "Claim",
            "Sentence",
            "Result",
            "Checks held",
            "Margin [points]",
            "Each δ may move [points]",
        ),
        rows=tuple(_claim_cells(result) for result in results),
        text_columns=(0, 1, 2),
        note="At the configured start phase. Margin: how far one δ behind a claim could move before its"
        " result turns; negative if it does not hold. If it is a difference of two δ, both may move,"
        " each by half of it. Open: a run is missing or failed, its healthy run does not move, or there is no"
        " such mode.",
    )


def _claim_cells(result: ClaimResult) -> tuple[Cell, ...]:
    held = sum(check.holds is True for check in result.checks)
    return (
        Cell(result.claim.id),
        Cell(result.claim.sentence),
        Cell(word(result.reproduced), result.reproduced is False, word(result.reproduced)),
        Cell(f"{held} of {len(result.checks)}"),
        Cell(signed(result.margin, 2), value=result.margin),
        Cell(signed(result.allowance, 2), value=result.allowance),
    )


def _checks_sheet(study: Study) -> Sheet:
    checks = [(result, check) for result in study.claims for check in result.checks]
    return Sheet(
        key="checks",
        title="Checks",
        headers=("Claim", "Rule", "Modes", "Holds", "Margin [points]", "Runs"),
        rows=tuple(_check_cells(study, result, check) for result, check in checks),
        breaks=group_breaks([result.claim.id for result, _ in checks]),
        text_columns=(0, 1, 2, 3, 5),
        note="Runs: the healthy run that δ is taken against, then the leaky ones.",
    )


def _check_cells(study: Study, result: ClaimResult, check: CheckResult) -> tuple[Cell, ...]:
    holds = {True: "yes", False: "no", None: "open"}[check.holds]
    return (
        Cell(result.claim.id),
        Cell(result.claim.rule),
        Cell(modes_text(study, check)),
        Cell(holds, check.holds is False),
        Cell(signed(check.margin, 2), value=check.margin),
        Cell(" ".join(run_id[:6] for run_id in check.run_ids)),
    )


def modes_text(study: Study, check: CheckResult) -> str:
    """The modes that a check looks at."""
    grid = study.grid
    labels = labels_text(grid.scenarios[check.scenario])
    if len(check.modes) > 3 and len(check.modes) == grid.n_mode:
        text = f"all {counted(len(check.modes), 'leaky mode')}"
    else:
        text = ", ".join(mode_name(grid.leakage_flows[q], grid.bulk_moduli[b]) for q, b in check.modes)
    return f"{text} ({labels})" if labels else text
