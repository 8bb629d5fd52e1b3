"""Probability of detection over the severity, for the foremost scores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.smallest import lower_bound
from hydrofdi.evaluation.scores import Array
from hydrofdi.report.detection.wording import SeverityUnit, sensors, severity_unit
from hydrofdi.report.figures.detection.marks import panels, sensor_marks, titled, with_threshold
from hydrofdi.report.figures.style import INK, LINES, log_axis
from hydrofdi.studies.judgement import Detection, Judgement

_MOST, _POINTS, _COARSE = 6, 201, 13
"""Panels; points of a curve, and the first ones of its bound."""

_STEP, _HALVINGS = 0.08, 7
"""Points of the bound are added until it rises by less from one to the next, in at most so many rounds."""


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
    severities, low = bound_line(curves, found.severity, found.confidence)
    axis.plot(_in_unit(severities, unit), 100.0 * low, color=color, linestyle=LINES[1], linewidth=0.8)


def bound_line(curves: Sequence[PodCurve], found: float, confidence: float) -> tuple[Array, Array]:
    """The lower bound of all curves that a severity was found from: close points where it rises.

    Parameters
    ----------
    curves : sequence of PodCurve
    found : float
        The severity that was found, which becomes a point [unit of the severity].
    confidence : float
        One-sided.

    Returns
    -------
    severity, low : ndarray, shape (n,)
    """

    def low_at(severities: Array) -> Array:
        lows = [lower_bound(curve, severities, confidence=confidence) for curve in curves]
        return np.asarray(np.min(lows, axis=0))

    severities = np.unique([*np.geomspace(*curves[0].tally.span, _COARSE), found])
    low = low_at(severities)
    for _ in range(_HALVINGS):
        wide = np.flatnonzero(np.diff(low) > _STEP)
        if not wide.size:
            break
        middle = np.sqrt(severities[wide] * severities[wide + 1])
        severities, low = np.insert(severities, wide + 1, middle), np.insert(low, wide + 1, low_at(middle))
    return severities, low


def _in_unit(severities: Array, unit: SeverityUnit) -> list[float]:
    return [unit.value(severity) for severity in severities.tolist()]
