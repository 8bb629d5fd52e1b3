"""Probability of detection over the severity, for the foremost scores."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.pod.bounds import curve_bounds
from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.likelihood import log_likelihood
from hydrofdi.evaluation.scores import Array
from hydrofdi.report.detection.wording import SeverityUnit, sensors, severity_unit
from hydrofdi.report.figures.detection.marks import panels, sensor_marks, titled, with_threshold
from hydrofdi.report.figures.style import INK, LINES
from hydrofdi.report.figures.ticks import log_axis
from hydrofdi.studies.detectability import SIGNIFICANCE
from hydrofdi.studies.judgement import Detection, Judgement

_MOST, _POINTS, _BOUNDS, _SEVERITIES = 6, 101, 21, 60
"""Panels; points of a curve and of its bounds; severities that the bounds are taken over."""


def draw_pod(detection: Detection) -> Any:
    """Levels, curve and bounds of each, a panel each.

    Raises
    ------
    ReportError
        No fault was tested, or no score has a threshold.
    """
    shown = [
        each for each in with_threshold(detection, _MOST) if any(level.detected for level in each.levels)
    ]
    if not shown:
        raise ReportError("no faulty record is tested")
    marks, unit = sensor_marks(detection, shown), severity_unit(detection)
    figure, axes = panels(len(shown), 3, width=3.0, height=2.5, sharex=True, sharey=True)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_one(axis, judgement, unit, marks[sensors(judgement)])
        axis.axhline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.7, linestyle=":")
        axis.axhline(100.0 * detection.rules.probability, color=INK, linewidth=0.5)
        log_axis(axis.xaxis)
        axis.set_title(titled(judgement), fontsize=8.5)
    axes[0].set_ylim(-3.0, 103.0)
    figure.supxlabel(f"{unit.quantity}{f' [{unit.name}]' if unit.name else ''}", fontsize=9)
    figure.supylabel("records detected [%]", fontsize=9)
    return figure


def _draw_one(axis: Any, judgement: Judgement, unit: SeverityUnit, mark: dict[str, Any]) -> None:
    curve = judgement.curve
    if curve is not None and not curve.is_step and curve.tally.severity.size > 1:
        is_described = judgement.lack_of_fit is None or not judgement.lack_of_fit.p_value < SIGNIFICANCE
        _draw_curve(axis, curve, unit, mark["color"], _confidence(judgement) if is_described else None)
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


def _draw_curve(axis: Any, curve: PodCurve, unit: SeverityUnit, color: str, confidence: float | None) -> None:
    """The curve with its bounds; dashed and without them where it does not describe the levels."""
    fine, coarse = (np.geomspace(*curve.tally.span, count) for count in (_POINTS, _BOUNDS))
    line = LINES[1] if confidence is None else LINES[0]
    axis.plot(_in_unit(fine, unit), 100.0 * curve.probability(fine), color=color, linestyle=line)
    if confidence is not None:
        low, high = curve_bounds(_drawn(curve), coarse, confidence=confidence)
        shown = {"color": color, "alpha": 0.2, "linewidth": 0}
        axis.fill_between(_in_unit(coarse, unit), 100.0 * low, 100.0 * high, **shown)


def _in_unit(severities: Array, unit: SeverityUnit) -> list[float]:
    return [unit.value(severity) for severity in severities.tolist()]


def _confidence(judgement: Judgement) -> float:
    return next(level.detected.confidence for level in judgement.levels if level.detected is not None)


def _drawn(curve: PodCurve) -> PodCurve:
    """The curve over fewer severities where there are very many: its bounds then take less time."""
    counted = curve.tally.pooled(_SEVERITIES)
    if counted is curve.tally:
        return curve
    best = log_likelihood(curve.predictor(counted.severity), counted, curve.false_alarm_rate, curve.link)
    return replace(curve, tally=counted, log_likelihood=best)
