"""What the conclusions depend on: margins over the start phases, and shares over the scenarios."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.claims import CLAIMS, Outcome
from hydrofdi.papers.maddahi2015.scenarios import CLAIM_SETS, ScenarioStudy, value_text
from hydrofdi.report.figures.style import BLUE, GREEN, INK, ORANGE, RULE

if TYPE_CHECKING:
    from hydrofdi.papers.maddahi2015.data import StudyData

_SENTENCES = {claim.id: fill(f"{claim.id}: {claim.sentence}", 38) for claim in CLAIMS}
"""Claim → its sentence on short lines."""

_LOOKS = {
    "as configured": (BLUE, ORANGE, -0.16, "the configured phase"),
    "settled": (GREEN, INK, 0.16, "settled: undecimated transform, no phase"),
}
"""Records → colours of the phases and of the number, height above the line, and what the number is."""


def draw_phases(study: StudyData) -> Figure:
    """Margins of the claims, and δd3 of the sealed actuator, at every start phase."""
    if study.standings[0].n_phase < 2:
        raise ReportError("only one start phase was measured; set wavelet: {phase: all}")
    if study.scenarios is not None:
        raise ReportError("an ensemble has many scenarios; the figure shows the phases of one")
    if not study.sealed or study.grid.lack:
        raise ReportError("the experiment has no claims and no sealed run above the normal EBM")
    n_claim, n_alarm = len(CLAIMS), len(study.sealed)
    figure = Figure(figsize=(8.6, 2.2 + 0.46 * (n_claim + n_alarm)), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=(n_claim + 0.6, n_alarm + 0.6))
    _draw_outcomes(top, study.claim_outcomes)
    top.set(title="margin of each claim: it holds right of zero", xlabel="margin [percentage points]")
    _draw_outcomes(bottom, study.alarm_outcomes)
    bottom.set(
        title="the sealed actuator against the fixed baseline: no leak, and an alarm", xlabel="δd3 [%]"
    )
    figure.legend(*top.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _draw_outcomes(axis: Any, outcomes: list[Outcome]) -> None:
    for title in dict.fromkeys(each.records for each in outcomes):
        color, mark, offset, label = _LOOKS[title]
        own = [each for each in outcomes if each.records == title]
        heights = np.arange(len(own)) + offset
        low, high = np.array([(min(each.values), max(each.values)) for each in own]).T
        axis.hlines(heights, low, high, color=color, linewidth=2.5, label=f"{title}: range")
        numbers = [each.number for each in own]
        axis.plot(numbers, heights, linestyle="none", marker="D", color=mark, markersize=5.0, label=label)
        for each, height in zip(own, heights, strict=True):
            axis.annotate(
                f"{each.held} of {each.of}", (1.01, height), xycoords=("axes fraction", "data"),
                va="center", fontsize=7.5, color=INK, annotation_clip=False,
            )  # fmt: skip
    names = [_SENTENCES.get(name, name) for name in dict.fromkeys(each.name for each in outcomes)]
    axis.axvline(0.0, color=INK, linewidth=0.8)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)


def draw_scenarios(study: StudyData) -> Figure:
    """Share of the feasible scenarios that reproduce each claim, and C1–C4 by parameter value."""
    scenarios = study.scenarios
    if scenarios is None:
        raise ReportError("the experiment has no ensemble")
    if not scenarios.feasible.any():
        raise ReportError("no scenario is feasible")
    heights, labels = _layout(scenarios)
    ratios = [len(CLAIM_SETS) * 0.36 + 0.6, len(labels) * 0.2 + 0.6]
    figure = Figure(figsize=(7.4, sum(ratios) + 0.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=ratios)
    _draw_claims(top, scenarios)
    _draw_values(bottom, scenarios, heights)
    bottom.set_yticks(list(labels), list(labels.values()), fontsize=7.5)
    bottom.invert_yaxis()
    if bottom.get_legend_handles_labels()[0]:
        figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _draw_claims(axis: Any, study: ScenarioStudy) -> None:
    total = int(study.feasible.sum())
    counts = [study.count(claims, study.feasible) for claims in CLAIM_SETS.values()]
    shares = [100.0 * int(study.reproducing(claims).sum()) / total for claims in CLAIM_SETS.values()]
    colors = [BLUE if len(claims) == 1 else ORANGE for claims in CLAIM_SETS.values()]
    bars = axis.barh(range(len(shares)), shares, color=colors, height=0.7)
    texts = ["open" if count is None else f"{count:,}" for count in counts]
    axis.bar_label(bars, texts, padding=3, fontsize=8, color=INK)
    axis.set_yticks(range(len(shares)), [_SENTENCES.get(name, name) for name in CLAIM_SETS], fontsize=7.5)
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    axis.set(
        xlim=(0.0, 109.0),
        title=f"scenarios that reproduce the claims, of {total:,} feasible ones",
        xlabel="share of the feasible scenarios [%]",
    )


def _draw_values(axis: Any, study: ScenarioStudy, heights: list[float]) -> None:
    for name, color, marker, size in (("C1–C4", ORANGE, "o", 7.5), ("C1–C6", BLUE, "D", 4.0)):
        claims = CLAIM_SETS[name]
        if study.is_open(claims):
            continue
        mask, decided = study.reproducing(claims), study.decided(claims)
        members = [(value.members & decided, value.members & mask) for value in study.value_shares]
        shares = [
            100.0 * int(held.sum()) / int(all_.sum()) if all_.any() else np.nan for all_, held in members
        ]
        axis.axvline(100.0 * mask.sum() / decided.sum(), color=color, linewidth=0.8, linestyle=":")
        axis.plot(
            shares, heights, linestyle="none", clip_on=False, label=name, color=color, marker=marker,
            markersize=size,
        )  # fmt: skip
    axis.grid(color=RULE, axis="y")
    axis.set(
        title="the same by parameter value; dotted: over all",
        xlabel="share of the feasible scenarios with this value [%]",
    )
    axis.set_xlim(left=0.0)


def _layout(study: ScenarioStudy) -> tuple[list[float], dict[float, str]]:
    """Height of each value, and what stands at the heights, parameters above their values."""
    heights: list[float] = []
    labels: dict[float, str] = {}
    previous = None
    for value in study.value_shares:
        if value.parameters != previous:
            labels[float(len(labels))] = ", ".join(value.parameters)
        heights.append(float(len(labels)))
        labels[heights[-1]] = value_text(value)
        previous = value.parameters
    return heights, labels
