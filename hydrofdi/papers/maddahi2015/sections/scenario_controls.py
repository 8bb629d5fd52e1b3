"""The controls of the scenarios study: over all feasible scenarios, and over those that reproduce claims."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrofdi.papers.maddahi2015.scenarios.study import CORE, Mask, ScenarioStudy
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.runs import level_name
from hydrofdi.report.wording import joined, mode_name, modulus_text, share_text
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE


def scenario_controls_block(study: ScenarioStudy) -> Block:
    """The sealed alarm and the best level, unconditional and where claims hold."""
    return Block(
        "scenarios-controls",
        "Controls over the scenarios",
        tuple(_sentences(study)),
        (_alarms_sheet(study), _best_levels_sheet(study)),
    )


def _groups(study: ScenarioStudy) -> dict[str, Mask]:
    """Name → scenarios that the controls are counted over."""
    groups = {"all feasible": study.feasible}
    if study.doubts:
        groups["all runs are ok"] = study.sound
    if not study.is_open(("C4",)):
        fourth = study.reproducing(("C4",))
        groups |= {"C4 holds": fourth, "C4 fails": study.decided(("C4",)) & ~fourth}
    if not study.is_open(CORE):
        groups["C1–C4 hold"] = study.reproducing(CORE)
    return groups


def _sentences(study: ScenarioStudy) -> Iterator[str]:
    groups, alarms = _groups(study), study.configured.alarms_everywhere
    parts = [
        f"{_share(study, alarms, members)} where {name}" for name, members in groups.items() if members.any()
    ]
    if parts and study.grid.raised:
        yield (
            "The d3 rule alarms on the sealed actuator at every EBM above normal in"
            f" {joined(parts).replace('where all feasible', 'of all feasible scenarios')}."
        )
    if "C4 holds" in groups:
        yield (
            "C4 asks for the largest δd3 with a leak, which is nearly what the alarm asks for without one:"
            " shares given C4 or C1–C4 are conditional on much of their outcome."
        )
    if "C1–C4 hold" not in groups:
        yield "C1–C4 are open: no scenario tests all."
    elif not groups["C1–C4 hold"].any():
        yield "No feasible scenario reproduces C1–C4."
    yield from _best_level_sentence(study, groups)


def _best_level_sentence(study: ScenarioStudy, groups: dict[str, Mask]) -> Iterator[str]:
    columns = _raised_modes(study)
    if not columns:
        return
    second = study.best_levels[:, columns] == 1
    parts = [
        f"{_share(study, second, members)} ({name})" for name, members in groups.items() if members.any()
    ]
    yield (
        f"Under the matched baseline d2 is the best level in {joined(parts)} of the"
        f" {counted(len(columns), 'leaky mode')} above the normal EBM. At the normal EBM both baselines are"
        " one, and C1 itself asks that d2 is best there: those modes are left out."
    )


def _raised_modes(study: ScenarioStudy) -> list[int]:
    """Columns of the leaky modes above the normal EBM."""
    return [column for column, (_, b) in enumerate(study.grid.modes()) if b in study.grid.raised]


def _share(study: ScenarioStudy, outcomes: Mask, members: Mask) -> str:
    return share_text(study.share(outcomes, members), with_interval=study.is_drawn)


def _alarms_sheet(study: ScenarioStudy) -> Sheet:
    views = [view for view in (study.configured, study.settled) if view is not None]
    moduli = [modulus_text(study.grid.bulk_moduli[b]) for b in study.grid.raised]
    headers = ["Scenarios", "Number", *moduli, "At every EBM", "At every EBM and phase"]
    headers += ["Settled: at every EBM", "Settled: at every EBM and phase"] if study.settled else []
    rows = []
    for name, members in _groups(study).items():
        cells = [Cell(name), Cell(f"{int(members.sum()):,}", value=int(members.sum()))]
        cells += [Cell(_share(study, study.alarms[:, k], members)) for k in range(len(moduli))]
        for view in views:
            outcomes = (view.alarms_everywhere, view.alarms_throughout)
            cells += [Cell(_share(study, outcome, members)) for outcome in outcomes]
        rows.append(tuple(cells))
    return Sheet(
        "scenarios-alarms",
        "The d3 rule on the sealed actuator: share of scenarios with an alarm",
        tuple(headers),
        tuple(rows),
        text_columns=(0,),
    )


def _best_levels_sheet(study: ScenarioStudy) -> Sheet:
    grid, rows, keys = study.grid, [], []
    for column in _raised_modes(study):
        q, b = grid.modes()[column]
        for name in ("all feasible", "C1–C4 hold"):
            members = _groups(study).get(name, np.zeros(study.n_scenario, dtype=bool))
            best = study.best_levels[members, column]
            counts = [int((best == level).sum()) for level in (*range(grid.n_level), -1)]
            texts = [f"{100.0 * count / best.size:.1f} %" if best.size else HOLE for count in counts]
            cells = [
                Cell(text, bool(best.size) and count == max(counts), count)
                for text, count in zip(texts, counts, strict=True)
            ]
            rows.append((Cell(mode_name(grid.leakage_flows[q], grid.bulk_moduli[b])), Cell(name), *cells))
            keys.append((q, b))
    levels = [level_name(level) or "" for level in range(grid.n_level)]
    return Sheet(
        "scenarios-best-levels",
        "The best level of each mode above the normal EBM against the matched baseline",
        ("Mode", "Scenarios", *levels, "none"),
        tuple(rows),
        breaks=group_breaks(keys),
        text_columns=(0, 1),
    )
