"""Claims and the sealed alarm over the start phases: one phase is not a finding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.claims import CLAIMS
from hydrofdi.papers.maddahi2015.standings import PhaseCount, Standing
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.style import BLUE, GREEN, INK, ORANGE
from hydrofdi.report.wording import labels_text, modulus_text

_OFFSET = 0.16
"""How far the two kinds of records stand above and below their line."""


def draw_phases(study: Study) -> Figure:
    """Margins of the claims, and δd3 of the sealed actuator, at every start phase."""
    standings = study.standings
    if standings[0].n_phase < 2:
        raise ReportError("only one start phase was measured; set wavelet: {phase: all}")
    if study.scenarios is not None:
        raise ReportError("an ensemble has many scenarios; the figure shows the phases of one")
    if not study.sealed_alarms or study.grid.lack:
        raise ReportError("the experiment has no claims and no sealed run above the normal EBM")
    n_claim, n_alarm = len(CLAIMS), len(study.sealed_alarms)
    figure = Figure(figsize=(7.4, 2.2 + 0.42 * (n_claim + n_alarm)), layout="constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=(n_claim + 0.6, n_alarm + 0.6))
    claims = [claim.id for claim in CLAIMS]
    _draw(
        top, standings, claims, lambda standing, k: (standing.claims[claims[k]], standing.margins[claims[k]])
    )
    top.set_title("margin of each claim: it holds right of zero")
    top.set_xlabel("margin [percentage points]")
    names = [_alarm_name(study, k) for k in range(n_alarm)]
    _draw(bottom, standings, names, lambda standing, k: (standing.alarms[k], standing.alarm_deltas[k][2]))
    bottom.set_title("the sealed actuator against the fixed baseline: no leak, and an alarm")
    bottom.set_xlabel("δd3 [%]")
    figure.legend(*top.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _alarm_name(study: Study, place: int) -> str:
    alarm = study.sealed_alarms[place]
    return ", ".join(filter(None, [modulus_text(alarm.bulk_modulus), labels_text(alarm.labels)]))


def _draw(axis: Any, standings: Sequence[Standing], names: Sequence[str], numbers: Any) -> None:
    styles = (("as configured", BLUE, -_OFFSET), ("settled", GREEN, _OFFSET))
    for standing, (title, color, offset) in zip(standings, styles, strict=False):
        counts: list[tuple[PhaseCount, float]] = [numbers(standing, k) for k in range(len(names))]
        heights = np.repeat(np.arange(len(names)) + offset, standing.n_phase)
        values = [value for count, _ in counts for value in count.values]
        label = f"{title}: each phase"
        axis.plot(
            values, heights, "o", color=color, markersize=3.0, alpha=0.45, markeredgewidth=0, label=label
        )
        label = "the configured phase" if title == "as configured" else "settled: all phases together"
        mark = {"marker": "D", "color": ORANGE if title == "as configured" else INK, "markersize": 5.0}
        axis.plot(
            [value for _, value in counts],
            np.arange(len(names)) + offset,
            linestyle="none",
            label=label,
            **mark,
        )
        for k, (count, _) in enumerate(counts):
            axis.annotate(
                f"{count.held} of {count.of}", (1.01, k + offset), xycoords=("axes fraction", "data"),
                va="center", fontsize=7.5, color=INK, annotation_clip=False,
            )  # fmt: skip
    axis.axvline(0.0, color=INK, linewidth=0.8)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)
