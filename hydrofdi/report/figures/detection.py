"""Panels of scores and severities: values in each population, false alarms, ROC, probability of detection."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from hydrofdi.errors import NotStatedError, ReportError
from hydrofdi.evaluation.rates import RocCurve, roc_curve
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.report.detection.wording import (
    SeverityUnit,
    chosen_levels,
    foremost,
    level_of,
    sensors,
    severity_unit,
    tested,
)
from hydrofdi.report.figures import (
    BLUE,
    COLORS,
    GREEN,
    INK,
    LINES,
    MARKERS,
    ORANGE,
    PAPER,
    PINK,
    legend_outside,
    log_axis,
    logit_axis,
    panels,
    root_percent_axis,
    row_axis,
)
from hydrofdi.settings.messages import convert, readable_unit, typeset
from hydrofdi.studies.judging import reference_of
from hydrofdi.studies.records import Detection, Judgement, part

_MOST, _MOST_LEVELS = 6, 7
"""Scores, and leaking populations beside the others."""

_N_BIN, _WIDEST = 50, 4.0
"""Bins, and how far beyond the healthy scores they reach, in widths of these."""

_COLORS = {Kind.HEALTHY: BLUE, Kind.SHIFT: GREEN, Kind.CONFUSION: PINK, Kind.FAULT: ORANGE}


def sensor_marks(detection: Detection, shown: Sequence[Judgement]) -> dict[str, dict[str, Any]]:
    """Sets of sensors of the shown scores → colour and marker, which are the same in all figures.

    The largest set of the study comes first; all beyond seven have the last mark.
    """
    sizes = {sensors(judgement): len(judgement.scored.channels) for judgement in detection.judgements}
    ordered = sorted(sizes, key=lambda name: (-sizes[name], name))
    last = len(COLORS) - 1
    return {
        name: {"color": COLORS[min(index, last)], "marker": MARKERS[min(index, last)]}
        for index, name in enumerate(ordered)
        if name in {sensors(each) for each in shown}
    }


def with_threshold(detection: Detection, most: int) -> tuple[Judgement, ...]:
    """The foremost scores that have a threshold."""
    shown = tuple(each for each in foremost(detection, most) if each.threshold is not None)
    shown = shown or tuple(each for each in detection.judgements if each.threshold is not None)[:most]
    if not shown:
        raise ReportError("no score has a threshold")
    return shown


def _titled(judgement: Judgement, width: int = 30) -> str:
    """Name and sensors over a panel; a long name is broken after its dot, then after underscores."""
    name, needs = judgement.scored.name, sensors(judgement)
    if len(name) > width:
        head, dot, tail = name.partition(".")
        parts = [head + dot, *wrap(tail.replace("_", "_ "), width)]
        name = "\n".join(part.replace("_ ", "_") for part in parts)
    return name if f"({needs})" in name else f"{name}\n({needs})"


def score_panels(shown: Sequence[Judgement], height: float, **more: Any) -> tuple[Any, list[Any]]:
    """A figure with a panel for each score."""
    figure, axes = panels(len(shown), 3, width=3.0, height=height, sharey=True, **more)
    for axis, judgement in zip(axes, shown, strict=True):
        axis.set_title(_titled(judgement), fontsize=8.5)
    return figure, axes


def draw_densities(detection: Detection) -> Any:
    """A ridge for each population, a panel for each of the foremost scores.

    Raises
    ------
    ReportError
        There is no score.
    """
    shown = foremost(detection, _MOST)
    if not shown:
        raise ReportError("no indicator could measure any record")
    populations = _populations(detection)
    height = 0.9 + 0.28 * len(populations)
    figure, axes = score_panels(shown, height)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_densities(axis, detection, judgement, populations)
    rows = range(len(populations))
    axes[0].set_yticks(rows, [_label(population) for population in populations], fontsize=8)
    axes[0].set_ylim(len(populations) - 0.8, -1.1)
    return figure


def _populations(detection: Detection) -> tuple[Population, ...]:
    """Healthy, shifted and confused ones, and some of the leaking ones."""
    sound, chosen = (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION), chosen_levels(detection, _MOST_LEVELS)
    populations = detection.records.populations
    return tuple(population for population in populations if population.kind in sound or population in chosen)


def _draw_densities(
    axis: Any, detection: Detection, judgement: Judgement, populations: tuple[Population, ...]
) -> None:
    scores = [judgement.scored.values[detection.records.rows(population)] for population in populations]
    scores = [own[np.isfinite(own)] for own in scores]
    healthy = [own for own, each in zip(scores, populations, strict=True) if each.kind is Kind.HEALTHY]
    ends = () if judgement.threshold is None else (judgement.threshold.low, judgement.threshold.high)
    limits = [end for end in ends if np.isfinite(end)]
    edges = _edges(np.concatenate([limits, *healthy]), np.concatenate(scores))
    unit = readable_unit(judgement.scored.unit, float(np.abs(edges).max()))
    scale = convert(1.0, unit, judgement.scored.unit)
    for row, (population, own) in enumerate(zip(populations, scores, strict=True)):
        # Scores beyond either end stand in the last bin there.
        counts, _ = np.histogram(np.clip(own, edges[0], edges[-1]), edges)
        if counts.any():
            ridge, color = row - 0.95 * counts / counts.max(), _COLORS[population.kind]
            axis.stairs(ridge, edges * scale, baseline=row, fill=True, color=color, alpha=0.35)
            axis.stairs(ridge, edges * scale, baseline=row, color=color, linewidth=0.7)
    for limit in limits:
        axis.axvline(limit * scale, color=INK, linewidth=0.9)
    axis.set_xlim(edges[0] * scale, edges[-1] * scale)
    axis.set_xlabel("score" if unit == "1" else f"score [{typeset(unit)}]", fontsize=8)
    axis.locator_params(axis="x", nbins=4)
    axis.ticklabel_format(axis="x", useOffset=False)


def _edges(healthy: Array, scores: Array) -> Array:
    """Edges of the bins: all scores, if the healthy ones remain visible."""
    if not healthy.size:
        return np.linspace(0.0, 1.0, _N_BIN + 1)
    low, high = healthy.min(), healthy.max()
    reach = _WIDEST * (high - low) or max(abs(high), 1.0)
    low, high = max(scores.min(initial=low), low - reach), min(scores.max(initial=high), high + reach)
    margin = 0.03 * (high - low) or 0.5 * reach
    return np.linspace(low - margin, high + margin, _N_BIN + 1)


def _label(population: Population) -> str:
    is_named = not population.is_fit or "fit" in population.name
    return population.name if is_named else f"{population.name} (fit)"


def draw_false_alarms(detection: Detection) -> Any:
    """Rates of healthy test records, shifts and confusions, a panel for each of the foremost scores.

    Raises
    ------
    ReportError
        There are no such records, or no score has a threshold.
    """
    shown = with_threshold(detection, _MOST)
    populations = tested(detection, Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)
    if not populations:
        raise ReportError("no record with a healthy seal is tested")
    marks = sensor_marks(detection, shown)
    height = 0.8 + 0.24 * len(populations)
    figure, axes = score_panels(shown, height, sharex=True, x="records that raise an alarm [%]")
    rates = [rate for each in shown for one, rate in each.false_alarms.items() if one in populations]
    highest = max([2.0 * detection.rules.false_alarm_rate, *(rate.high for rate in rates if rate.total)])
    for axis, judgement in zip(axes, shown, strict=True):
        root_percent_axis(axis, 100.0 * highest)
        for row, population in enumerate(populations):
            _draw_rate(axis, row, judgement, population, marks[sensors(judgement)])
        axis.axvline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.9)
    row_axis(axes[0], [population.name for population in populations])
    return figure


def _draw_rate(
    axis: Any, row: int, judgement: Judgement, population: Population, mark: dict[str, Any]
) -> None:
    rate = judgement.false_alarms.get(population)
    if rate is None or not rate.total:
        return
    face = {"markerfacecolor": PAPER} if population in judgement.counted else {}
    axis.plot([100.0 * rate.low, 100.0 * rate.high], [row, row], color=mark["color"], linewidth=1.2)
    axis.plot(100.0 * rate.value, row, **mark, **face, markersize=5, linestyle="none", clip_on=False)


_LEAST = 0.001
"""Smallest rate on the axes."""


def draw_roc(detection: Detection) -> Any:
    """Detections against false alarms: a panel for each of some severities, a line for each score.

    Raises
    ------
    ReportError
        There are no healthy or no faulty records to test.
    """
    shown, levels = with_threshold(detection, _MOST), chosen_levels(detection, 3)
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
    point = np.clip([healthy[0].value, stated.detected.value], _LEAST, 1.0 - _LEAST)
    axis.plot(*point, marker="o", markersize=4, color=color, clip_on=False)


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


_POINTS = 201
"""Points of a curve."""


def draw_pod(detection: Detection) -> Any:
    """Levels and curve of each, a panel each.

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
    labels = {"x": f"{unit.quantity}{unit.bracket}", "y": "records detected [%]"}
    figure, axes = score_panels(shown, 2.5, sharex=True, **labels)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_levels(axis, judgement, unit, marks[sensors(judgement)])
        axis.axhline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.7, linestyle=":")
        axis.axhline(100.0 * detection.rules.probability, color=INK, linewidth=0.5)
        log_axis(axis.xaxis)
    axes[0].set_ylim(-3.0, 103.0)
    return figure


def _draw_levels(axis: Any, judgement: Judgement, unit: SeverityUnit, mark: dict[str, Any]) -> None:
    _draw_fitted(axis, judgement, unit, mark["color"])
    for level in judgement.levels:
        rate = level.detected
        if rate is not None and rate.total:
            severity = unit.value(level.severity if level.severity > 0.0 else level.population.severity)
            spread = [[100.0 * (rate.value - rate.low)], [100.0 * (rate.high - rate.value)]]
            style = {"fmt": mark["marker"], "markersize": 3.5, "elinewidth": 0.7, "color": mark["color"]}
            axis.errorbar(severity, 100.0 * rate.value, spread, **style)
    bound = judgement.smallest.get("q90_95")
    if bound is not None and bound.value is not None:
        axis.axvline(unit.value(bound.value), color=mark["color"], linewidth=1.2)


def _draw_fitted(axis: Any, judgement: Judgement, unit: SeverityUnit, color: str) -> None:
    """The curve where q90 is taken from it."""
    curve = next(iter(judgement.bounding), judgement.curve)
    estimate = judgement.smallest.get("q90")
    if curve is None or estimate is None or estimate.source == "levels" or curve.tally.severity.size < 2:
        return
    severities = np.geomspace(*curve.tally.span, _POINTS)
    axis.plot([*map(unit.value, severities.tolist())], 100.0 * curve.probability(severities), color=color)
