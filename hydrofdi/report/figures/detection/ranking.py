"""What each score finds, the best on top."""

from __future__ import annotations

from textwrap import fill
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydrofdi.errors import ReportError
from hydrofdi.report.detection.selection import foremost
from hydrofdi.report.detection.wording import SeverityUnit, sensors, severity_unit
from hydrofdi.report.figures.detection.marks import sensor_marks
from hydrofdi.report.figures.style import PAPER, log_axis
from hydrofdi.studies.judgement import Detection, Judgement

_MOST, _LETTERS = 24, 115
"""Scores, and letters of a line below them."""


def draw_ranking(detection: Detection) -> Any:
    """q90 and q90/95 of the foremost scores, coloured by their sensors.

    Raises
    ------
    ReportError
        No score has a severity that can be stated.
    """
    shown = [each for each in foremost(detection, _MOST) if each.smallest]
    if not shown:
        raise ReportError("no score has a severity that can be stated")
    marks, unit = sensor_marks(detection, shown), severity_unit(detection)
    figure = Figure(figsize=(8.0, 1.6 + 0.26 * len(shown)), layout="constrained")
    axis = figure.subplots()
    for row, judgement in enumerate(shown):
        _draw_row(axis, row, judgement, unit, marks[sensors(judgement)])
    log_axis(axis.xaxis)
    axis.set_yticks(range(len(shown)), [_label(each) for each in shown], fontsize=8)
    axis.set_ylim(len(shown) - 0.4, -0.6)
    axis.set_xlabel(_axis_label(detection, unit))
    _legend(figure, marks)
    figure.supxlabel(_note(detection, shown), x=0.01, ha="left", fontsize=8)
    if len(shown) < len(detection.judgements):
        axis.set_title(f"the foremost {len(shown)} of {len(detection.judgements):,} scores")
    return figure


def _note(detection: Detection, shown: list[Judgement]) -> str:
    """What the marks mean, those that occur."""
    places = {found.place for each in shown for found in each.smallest.values()}
    parts = {
        "open: estimate": True,
        f"filled: bound with {100.0 * detection.rules.confidence:g} % confidence": True,
        "← at most the smallest tested": "below" in places,
        "→ not found up to the largest tested": "above" in places,
        "(in brackets): exceeds its false-alarm rate": any(each.keeps_its_rate is False for each in shown),
    }
    return fill("; ".join(text for text, occurs in parts.items() if occurs), _LETTERS)


def _label(judgement: Judgement) -> str:
    return judgement.scored.name if judgement.keeps_its_rate is not False else f"({judgement.scored.name})"


def _axis_label(detection: Detection, unit: SeverityUnit) -> str:
    share = f"{100.0 * detection.rules.probability:g} %"
    return f"{unit.quantity} found with {share} probability" + (f" [{unit.name}]" if unit.name else "")


def _draw_row(axis: Any, row: int, judgement: Judgement, unit: SeverityUnit, mark: dict[str, Any]) -> None:
    bound, estimate = judgement.smallest.get("q90_95"), judgement.smallest.get("q90")
    style = {**mark, "markersize": 5.5, "linestyle": "none"}
    found = (each.value for each in (estimate, bound) if each is not None)
    ends = [unit.value(value) for value in found if value is not None]
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


def _legend(figure: Any, marks: dict[str, dict[str, Any]]) -> None:
    style: dict[str, Any] = {"linestyle": "none", "markersize": 5.5}
    handles = [Line2D([], [], label=name, **mark, **style) for name, mark in marks.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 5), title="sensors")
