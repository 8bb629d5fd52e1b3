"""Figures 2 to 4 of a scenario, and margins of the claims over the start phases."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.claims import ABSENT, CLAIMS, PhaseCount
from hydrofdi.papers.maddahi2015.study import StudyData
from hydrofdi.report.document import FigureKind
from hydrofdi.report.figures import BLUE, GREEN, INK, ORANGE, series, time_axis
from hydrofdi.report.figures.signals import PANELS, details, draw_beside
from hydrofdi.report.runs import kilopascal, mode_name
from hydrofdi.store import names


def _position(study: StudyData, leakage: int, bulk_modulus: int) -> int:
    """Row of a run of the first scenario; `leakage` 0 is the sealed actuator, 1 the smallest leakage."""
    position = int(study.grid.positions[0, leakage, bulk_modulus])
    if position == ABSENT:
        raise ReportError("the experiment has no run of this leakage and EBM")
    status = study.data.columns[names.STATUS][position]
    if status != "ok":
        raise ReportError(f"a run of the figure has no results: {status}")
    return position


def _flow(study: StudyData, leakage: int) -> float:
    return study.grid.leakage_flows[leakage - 1] if leakage else 0.0


def _small_leak(study: StudyData) -> int:
    """The smallest leakage, or the sealed actuator if there is none."""
    return min(1, len(study.grid.leakage_flows))


def _pressures(study: StudyData, leakage: int) -> Iterator[tuple[float, int, Any, Any]]:
    """EBM, row, instants and P_1 of the runs of a leakage, at the EBM at which there is a small leak."""
    for beta in np.flatnonzero(study.grid.positions[0, _small_leak(study)] != ABSENT).tolist():
        position = _position(study, leakage, beta)
        time, pressure = study.data.signal(names.CHAMBER_1_PRESSURE, position)
        yield study.grid.bulk_moduli[beta], position, time, pressure


def draw_figure_2(study: StudyData) -> Figure:
    """Figure 2: (a) normal and (b) with the small leakage, both at the normal EBM."""
    grid, data = study.grid, study.data
    leakages = list(dict.fromkeys((0, _small_leak(study))))
    runs = [_position(study, leakage, grid.normal) for leakage in leakages]
    columns: dict[str, Any] = {name: [data.signal(name, run)[1] for run in runs] for name in PANELS}
    columns[names.TIME] = data.signal(names.CHAMBER_1_PRESSURE, runs[0])[0]
    columns[names.REFERENCE_POSITION] = [
        np.array([np.nan])
        if data.values("control.law")[run] == "open"
        else data.signal(names.REFERENCE_POSITION, run)[1]
        for run in runs
    ]
    modes = (mode_name(_flow(study, leakage), grid.bulk_moduli[grid.normal]) for leakage in leakages)
    titles = [f"({letter}) {mode}" for letter, mode in zip("ab", modes, strict=False)]
    return draw_beside(columns, titles, data.experiment.wavelet)


def draw_details(study: StudyData, level: int) -> Figure:
    """Figures 3 and 4: the coefficients of a level of P_1 with the small leakage, one panel per EBM."""
    wavelet, leakage = study.data.experiment.wavelet, _small_leak(study)
    if level > wavelet.levels:
        raise ReportError(f"the experiment has no level d{level}")
    runs = [*_pressures(study, leakage)]
    figure = Figure(figsize=(7.0, 0.6 + 1.6 * len(runs)), layout="constrained")
    axes: Any = figure.subplots(len(runs), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for number, (axis, (modulus, position, time, pressure)) in enumerate(zip(axes, runs, strict=True)):
        color = series(number)["color"]
        axis.plot(*details(pressure, wavelet, level, time), color=color, linewidth=0.7)
        rms = float(study.data.columns[names.DETAIL_RMS][position][level - 1])
        mode = mode_name(_flow(study, leakage), modulus)
        axis.set(title=f"{mode}: RMS {kilopascal(rms)} kPa", ylabel=f"$d_{level}$ of $P_1$ [kPa]")
    time_axis(axes[-1], time)
    return figure


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


def _draw_outcomes(axis: Any, outcomes: list[PhaseCount]) -> None:
    for title in dict.fromkeys(outcome.records for outcome in outcomes):
        color, mark, offset, label = _LOOKS[title]
        own = [outcome for outcome in outcomes if outcome.records == title]
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
    names = [_SENTENCES.get(name, name) for name in dict.fromkeys(outcome.name for outcome in outcomes)]
    axis.axvline(0.0, color=INK, linewidth=0.8)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)


def study_figures(study: StudyData) -> dict[str, FigureKind]:
    """Name → figure."""
    figures: dict[str, tuple[str, Callable[..., Any]]] = {
        "figure2": ("Figure 2: signals and d2 of P_1, normal and with the small leakage", draw_figure_2),
        "figure3": ("Figure 3: d2 of P_1 over the EBM, small leakage", partial(draw_details, level=2)),
        "figure4": ("Figure 4: d3 of P_1 over the EBM, small leakage", partial(draw_details, level=3)),
        "phases": ("Claims and the sealed alarm at every start phase, and settled", draw_phases),
    }
    return {name: FigureKind(caption, partial(draw, study)) for name, (caption, draw) in figures.items()}
