"""What is found: the answer in one picture, every score, how soon a chart alarms; all figures of a study."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.pod import DetectableSeverity
from hydrofdi.evaluation.scores import Population
from hydrofdi.records import Channel
from hydrofdi.report.detection import wording
from hydrofdi.report.detection.wording import answers, severity_unit
from hydrofdi.report.document import FigureKind
from hydrofdi.report.figures import (
    BLUE,
    GREY,
    INK,
    MARKERS,
    PAPER,
    legend_outside,
    log_axis,
    panels,
    row_axis,
    series,
)
from hydrofdi.report.figures.detection import (
    draw_densities,
    draw_false_alarms,
    draw_pod,
    draw_roc,
    sensor_marks,
)
from hydrofdi.settings.messages import convert
from hydrofdi.studies.records import ChartJudgement, Detection, Judgement

_MOST_SETS = 10
"""Sets of sensors."""


def draw_answer(detection: Detection) -> Any:
    """A line for each set of sensors that finds more than its parts, and for the best wavelet rule.

    Raises
    ------
    ReportError
        No score finds a leak at the rate of false alarms that is asked for.
    """
    if not (able := wording.answers(detection)):
        raise ReportError("no score is shown to find a leak at the false-alarm rate that is set")
    compared = [each for each in wording.wavelet_rules(detection) if each.smallest.get("q90_95") is not None][
        :1
    ]
    shown, unit = wording.distinct(*able[:_MOST_SETS], *compared), wording.severity_unit(detection)
    figure = Figure(figsize=(8.0, 1.9 + 0.5 * len(shown)), layout="constrained")
    axis = figure.subplots()
    axis.set_xscale("log")
    for row, judgement in enumerate(shown):
        _draw_found(axis, row, judgement, unit)
    row_axis(axis, [_answer_label(each) for each in shown], 10)
    axis.grid(visible=False, axis="y")
    low, high = axis.get_xlim()
    axis.set_xlim(low / 1.3, high * 1.6)
    log_axis(axis.xaxis)
    asked = detection.rules
    axis.set_xlabel(
        f"smallest {unit.quantity}{unit.bracket}: estimate to {100.0 * asked.confidence:g} % confidence",
        fontsize=10,
    )
    alarms = wording.false_alarms_in_words(asked.false_alarm_rate)
    title = f"{wording.probability_in_words(asked.probability)}, at {alarms}"
    figure.suptitle(f"The smallest {unit.quantity} that is found {title}", x=0.01, ha="left", fontsize=12)
    figure.supxlabel("\n".join([_symbols(shown), *_signs(shown, unit)]), x=0.01, ha="left", fontsize=9)
    return figure


def _answer_label(judgement: Judgement) -> str:
    """Sensors, and the score below them."""
    return f"{', '.join(wording.symbols(judgement))}\n{wording.score_title(judgement)}".strip()


def _draw_found(axis: Any, row: int, judgement: Judgement, unit: wording.SeverityUnit) -> None:
    """A line from the estimate to its bound, with the bound's number; an arrow where nothing is found."""
    bound = judgement.smallest["q90_95"]
    is_found = bound.value is not None
    end = unit.value(bound.severity if is_found else min(bound.severity, unit.largest))
    color = BLUE if is_found else GREY
    estimate = judgement.smallest.get("q90")
    if is_found and estimate is not None and estimate.value is not None:
        axis.plot([unit.value(estimate.severity), end], [row, row], color=color, linewidth=5, alpha=0.5)
    axis.plot(end, row, color=color, marker="|" if is_found else ">", markersize=9, markeredgewidth=3)
    text, offset = _number(bound, unit), {"ha": "left", "xytext": (9, 0)}
    if not is_found:
        offset = {"ha": "right", "xytext": (-9, 0)}
    style = {"textcoords": "offset points", "va": "center", "fontsize": 10, "color": INK}
    axis.annotate(text, (end, row), **style, **offset)


def _number(found: DetectableSeverity, unit: wording.SeverityUnit) -> str:
    if found.value is None:
        return f"not found up to {unit.found(found).removeprefix('> ')} {unit.name}".rstrip()
    return f"{unit.found(found)} {unit.name}".rstrip()


def _signs(shown: tuple[Judgement, ...], unit: wording.SeverityUnit) -> Iterator[str]:
    """What the signs beside the numbers mean, those that occur."""
    texts = "".join(_number(each.smallest["q90_95"], unit) for each in shown)
    if "≤" in texts:
        yield f"≤: at most the smallest {unit.quantity} tested"
    if wording.FROM_LEVELS in texts:
        yield f"{wording.FROM_LEVELS}: from the tested levels of {unit.quantity}, without a fitted curve"


def _symbols(shown: tuple[Judgement, ...]) -> str:
    """What the symbols of the sensors are."""
    used = {channel for each in shown for channel in each.scored.channels}
    parts = [f"{one.symbol}: {one.value.replace('_', ' ')}" for one in Channel if one.value in used]
    lines = [", ".join(parts[start : start + 4]) for start in range(0, len(parts), 4)]
    return "\n".join(lines)


_MOST, _LETTERS = 24, 115
"""Scores, and letters of a line below them."""


def draw_ranking(detection: Detection) -> Any:
    """q90 and q90/95 of the foremost scores, coloured by their sensors.

    Raises
    ------
    ReportError
        No score has a severity that can be stated.
    """
    shown = [each for each in wording.foremost(detection, _MOST) if each.smallest]
    if not shown:
        raise ReportError("no score has a severity that can be stated")
    marks, unit = sensor_marks(detection, shown), wording.severity_unit(detection)
    figure = Figure(figsize=(8.0, 1.6 + 0.26 * len(shown)), layout="constrained")
    axis = figure.subplots()
    for row, judgement in enumerate(shown):
        _draw_row(axis, row, judgement, unit, marks[wording.sensors(judgement)])
    log_axis(axis.xaxis)
    row_axis(axis, [_label(each) for each in shown])
    share = f"{100.0 * detection.rules.probability:g} %"
    axis.set_xlabel(f"{unit.quantity} found with {share} probability{unit.bracket}")
    points = {name: {**mark, "linestyle": "none", "markersize": 5.5} for name, mark in marks.items()}
    legend_outside(figure, points, min(len(points), 5), "sensors")
    figure.supxlabel(_note(detection, shown), x=0.01, ha="left", fontsize=8)
    if len(shown) < len(detection.judgements):
        axis.set_title(f"the foremost {len(shown)} of {len(detection.judgements):,} scores")
    return figure


def _note(detection: Detection, shown: list[Judgement]) -> str:
    """What the marks mean, those that occur."""
    sides = {bound.place for each in shown for bound in each.smallest.values()}
    parts = {
        "open: estimate": True,
        f"filled: bound with {100.0 * detection.rules.confidence:g} % confidence": True,
        "← at most the smallest tested": "below" in sides,
        "→ not found up to the largest tested": "above" in sides,
        "(in brackets): exceeds its false-alarm rate": any(each.keeps_its_rate is False for each in shown),
    }
    return fill("; ".join(text for text, occurs in parts.items() if occurs), _LETTERS)


def _label(judgement: Judgement) -> str:
    return judgement.scored.name if judgement.keeps_its_rate is not False else f"({judgement.scored.name})"


def _draw_row(
    axis: Any, row: int, judgement: Judgement, unit: wording.SeverityUnit, mark: dict[str, Any]
) -> None:
    bound, estimate = judgement.smallest.get("q90_95"), judgement.smallest.get("q90")
    style = {**mark, "markersize": 5.5, "linestyle": "none"}
    values = (each.value for each in (estimate, bound) if each is not None)
    ends = [unit.value(value) for value in values if value is not None]
    if len(ends) == 2:
        axis.plot(ends, [row, row], color=mark["color"], linewidth=1.2)
    arrow = {"color": mark["color"], "markersize": 11, "linestyle": "none"}
    if estimate is not None and estimate.place == "within":
        axis.plot(unit.value(estimate.severity), row, **style, markerfacecolor=PAPER)
    if bound is None:
        return
    if bound.place == "within":
        axis.plot(unit.value(bound.severity), row, **style)
    elif bound.place == "below":
        axis.plot(unit.value(bound.severity), row, marker=r"$\leftarrow$", **arrow)
    else:
        largest = unit.value(min(bound.severity, unit.largest))
        axis.plot(largest, row, marker=r"$\rightarrow$", **arrow)


def draw_delays(detection: Detection) -> Any:
    """A panel for each leak, a line for each chart.

    Raises
    ------
    ReportError
        No delay is stated.
    """
    levels = list(dict.fromkeys(delay.population for chart in detection.charts for delay in chart.delays))
    if not levels:
        raise ReportError("no leak sets in while a chart watches")
    labels = list(dict.fromkeys(chart.label for chart in detection.charts))
    marks = [{"marker": MARKERS[index % len(MARKERS)], "markersize": 3.5} for index in range(len(labels))]
    styles = {label: series(k, len(labels)) | marks[k] for k, label in enumerate(labels)}
    names = {"x": "mean time between false alarms that is asked for [h]", "y": "median delay [s]"}
    figure, axes = panels(len(levels), 4, width=2.6, height=2.6, sharex=True, sharey=True, **names)
    unit, every = (
        wording.severity_unit(detection),
        [convert(chart.false_alarm_every, "h") for chart in detection.charts],
    )
    for axis, level in zip(axes, levels, strict=True):
        for label, style in styles.items():
            _draw_line(axis, [chart for chart in detection.charts if chart.label == label], level, style)
        axis.set_title(unit.text(level.severity))
        axis.set_xlim(min(every) / 1.5, max(every) * 1.5)
        log_axis(axis.xaxis)
    axes[0].set_ylim(bottom=0.0)
    legend_outside(figure, styles, 4)
    return figure


def _draw_line(axis: Any, charts: Sequence[ChartJudgement], level: Population, style: dict[str, Any]) -> None:
    """Delays of a leak over the time between false alarms, ascending."""
    known = sorted(
        (
            convert(chart.false_alarm_every, "h"),
            delay.median.value,
            delay.median.low,
            min(delay.median.high, delay.watched),
        )
        for chart in charts
        for delay in chart.delays
        if delay.population == level and np.isfinite(delay.median.value)
    )
    every, medians, low, high = np.array(known).reshape(-1, 4).T
    axis.plot(every, medians, **style)
    axis.fill_between(every, low, high, color=style["color"], alpha=0.18, linewidth=0)


_FIGURES: dict[str, tuple[Callable[[Detection], Any], str]] = {
    "ranking": (draw_ranking, "The {quantity} found by each score with {share} probability"),
    "pod": (
        draw_pod,
        "Share of records detected over their {quantity}, with {confidence} intervals, and the fitted curve;"
        " vertical: q90/95 at {share}; dotted: the false-alarm rate of the threshold",
    ),
    "roc": (draw_roc, "Detections against false alarms over all thresholds; dots: the threshold in use"),
    "false_alarms": (
        draw_false_alarms,
        "Alarms of records whose seal is sound, with {confidence} intervals; open: too few records",
    ),
    "densities": (draw_densities, "Scores of each population; vertical lines: thresholds"),
    "answer": (draw_answer, "The smallest {quantity} that is found with each set of sensors"),
    "delays": (
        draw_delays,
        "Median delay from the onset of a leak to the alarm, over the time between false alarms",
    ),
}


def detection_figures(detection: Detection) -> dict[str, FigureKind]:
    """The figures of a judged study, and of its charts."""
    asked = detection.rules
    said = {
        "quantity": severity_unit(detection).quantity,
        "confidence": f"{100.0 * asked.confidence:g} %",
        "share": f"{100.0 * asked.probability:g} %",
    }
    is_there = {"answer": bool(answers(detection)), "delays": bool(detection.charts)}
    return {
        name: FigureKind(caption.format(**said), partial(draw, detection))
        for name, (draw, caption) in _FIGURES.items()
        if is_there.get(name, True)
    }
