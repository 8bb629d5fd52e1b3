"""Probability of detection over the severity; ROC curves on axes of log-odds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrofdi.errors import NotStatedError, ReportError
from hydrofdi.evaluation.rates import RocCurve, roc_curve
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.report.detection.wording import SeverityUnit, chosen_levels, level_of, sensors, severity_unit
from hydrofdi.report.figures.detection.populations import score_panels, sensor_marks, with_threshold
from hydrofdi.report.figures.style import INK, LINES, legend_outside, log_axis, logit_axis, panels
from hydrofdi.studies.judging import reference_of
from hydrofdi.studies.records import Detection, Judgement, part

_MOST_LINES = 6

_LEAST = 0.001
"""Smallest rate on the axes."""


def draw_roc(detection: Detection) -> Any:
    """Detections against false alarms: a panel for each of some severities, a line for each score.

    Raises
    ------
    ReportError
        There are no healthy or no faulty records to test.
    """
    shown, levels = with_threshold(detection, _MOST_LINES), chosen_levels(detection, 3)
    if not levels:
        raise ReportError("no faulty record is tested")
    unit = severity_unit(detection)
    styles = _styles(detection, shown)
    labels = {"x": "false alarms [%]", "y": "detections [%]"}
    figure, axes = panels(len(levels), 3, width=3.0, height=3.0, sharex=True, sharey=True, **labels)
    for axis, level in zip(axes, levels, strict=True):
        for judgement, style in zip(shown, styles, strict=True):
            if (curve := _curve(detection, judgement, level)) is not None:
                axis.plot(curve.false_alarm_rate, curve.detection_rate, **style)
                _draw_threshold(axis, judgement, level, style["color"])
        axis.set_title(unit.text(level.severity) if level.severity else level.name)
        _frame(axis, detection)
    legend_outside(figure, dict(zip(map(_named, shown), styles, strict=True)), 2)
    return figure


def _curve(detection: Detection, judgement: Judgement, level: Population) -> RocCurve | None:
    records, scored = detection.records, judgement.scored
    _, healthy, of = reference_of(records, scored, judgement.direction)
    try:
        return None if healthy is None else roc_curve(healthy, of(part(records, scored, [level]).scores))
    except NotStatedError:
        return None


def _draw_threshold(axis: Any, judgement: Judgement, level: Population, color: str) -> None:
    stated = level_of(judgement, level)
    rates = judgement.false_alarms
    healthy = [rates[population] for population in rates if population.kind is Kind.HEALTHY]
    if stated is None or stated.detected is None or not stated.detected.total or not healthy:
        return
    place = np.clip([healthy[0].value, stated.detected.value], _LEAST, 1.0 - _LEAST)
    axis.plot(*place, marker="o", markersize=4, color=color, clip_on=False)


def _styles(detection: Detection, shown: Sequence[Judgement]) -> list[dict[str, Any]]:
    """A colour for each set of sensors, a line style for each score."""
    marks = sensor_marks(detection, shown)
    return [
        {"color": marks[sensors(judgement)]["color"], "linestyle": LINES[index % len(LINES)]}
        for index, judgement in enumerate(shown)
    ]


def _frame(axis: Any, detection: Detection) -> None:
    """Axes, and where there is a curve, chance and the rate that thresholds are set for."""
    logit_axis(axis.xaxis, _LEAST)
    logit_axis(axis.yaxis, _LEAST)
    if axis.lines:
        ends = [_LEAST, 1.0 - _LEAST]
        axis.plot(ends, ends, color=INK, linewidth=0.6, linestyle="--")
        axis.axvline(detection.rules.false_alarm_rate, color=INK, linewidth=0.7)


def _named(judgement: Judgement) -> str:
    name, needs = judgement.scored.name, sensors(judgement)
    return name if f"({needs})" in name else f"{name} ({needs})"


_MOST_CURVES, _POINTS = 6, 201
"""Panels, and points of a curve."""


def draw_pod(detection: Detection) -> Any:
    """Levels and curve of each, a panel each.

    Raises
    ------
    ReportError
        No fault was tested, or no score has a threshold.
    """
    shown = [
        each
        for each in with_threshold(detection, _MOST_CURVES)
        if any(level.detected for level in each.levels)
    ]
    if not shown:
        raise ReportError("no faulty record is tested")
    marks, unit = sensor_marks(detection, shown), severity_unit(detection)
    labels = {"x": f"{unit.quantity}{unit.bracket}", "y": "records detected [%]"}
    figure, axes = score_panels(shown, 2.5, sharex=True, **labels)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_one(axis, judgement, unit, marks[sensors(judgement)])
        axis.axhline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.7, linestyle=":")
        axis.axhline(100.0 * detection.rules.probability, color=INK, linewidth=0.5)
        log_axis(axis.xaxis)
    axes[0].set_ylim(-3.0, 103.0)
    return figure


def _draw_one(axis: Any, judgement: Judgement, unit: SeverityUnit, mark: dict[str, Any]) -> None:
    _draw_fitted(axis, judgement, unit, mark["color"])
    for level in judgement.levels:
        rate = level.detected
        if rate is not None and rate.total:
            place = unit.value(level.severity if level.severity > 0.0 else level.population.severity)
            spread = [[100.0 * (rate.value - rate.low)], [100.0 * (rate.high - rate.value)]]
            style = {"fmt": mark["marker"], "markersize": 3.5, "elinewidth": 0.7, "color": mark["color"]}
            axis.errorbar(place, 100.0 * rate.value, spread, **style)
    found = judgement.smallest.get("q90_95")
    if found is not None and found.value is not None:
        axis.axvline(unit.value(found.value), color=mark["color"], linewidth=1.2)


def _draw_fitted(axis: Any, judgement: Judgement, unit: SeverityUnit, color: str) -> None:
    """The curve where q90 is taken from it."""
    curve = next(iter(judgement.bounding), judgement.curve)
    estimate = judgement.smallest.get("q90")
    if curve is None or estimate is None or estimate.source == "levels" or curve.tally.severity.size < 2:
        return
    severities = np.geomspace(*curve.tally.span, _POINTS)
    axis.plot([*map(unit.value, severities.tolist())], 100.0 * curve.probability(severities), color=color)
