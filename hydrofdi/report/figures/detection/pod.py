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
from hydrofdi.studies.judgement import Detection, Judgement

_MOST, _POINTS, _BOUNDS, _SEVERITIES = 6, 101, 21, 60
"""Panels; points of a curve and of its bounds; severities that the bounds are taken over."""


def draw_pod(detection: Detection) -> Any:
    """Levels, curve and bound of each, a panel each.

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
    _draw_curve(axis, judgement, unit, mark["color"])
    _draw_bound(axis, judgement, unit, mark["color"])
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


def _draw_curve(axis: Any, judgement: Judgement, unit: SeverityUnit, color: str) -> None:
    """The curve where q90 is taken from it."""
    curve = next(iter(judgement.bounding), judgement.curve)
    estimate = judgement.smallest.get("q90")
    if curve is None or estimate is None or estimate.source == "levels" or curve.tally.severity.size < 2:
        return
    severities = np.geomspace(*curve.tally.span, _POINTS)
    axis.plot(_in_unit(severities, unit), 100.0 * curve.probability(severities), color=color)


def _draw_bound(axis: Any, judgement: Judgement, unit: SeverityUnit, color: str) -> None:
    """The one-sided lower bound where q90/95 is taken from it: they meet at the probability asked for."""
    found, curves = judgement.smallest.get("q90_95"), judgement.bounding
    if not curves or found is None or found.source == "levels" or found.confidence is None:
        return
    severities = np.unique([*np.geomspace(*curves[0].tally.span, _BOUNDS), found.severity])
    two_sided = 2.0 * found.confidence - 1.0
    lows = [curve_bounds(_drawn(curve), severities, confidence=two_sided)[0] for curve in curves]
    low = 100.0 * np.min(lows, axis=0)
    axis.plot(_in_unit(severities, unit), low, color=color, linestyle=LINES[1], linewidth=0.8)


def _in_unit(severities: Array, unit: SeverityUnit) -> list[float]:
    return [unit.value(severity) for severity in severities.tolist()]


def _drawn(curve: PodCurve) -> PodCurve:
    """The curve over fewer severities where there are very many: its bounds then take less time."""
    counted = curve.tally.pooled(_SEVERITIES)
    if counted is curve.tally:
        return curve
    pooled, own = (
        log_likelihood(curve.predictor(each.severity), each, curve.false_alarm_rate, curve.link)
        for each in (counted, curve.tally)
    )
    return replace(curve, tally=counted, log_likelihood=curve.log_likelihood + pooled - own)
