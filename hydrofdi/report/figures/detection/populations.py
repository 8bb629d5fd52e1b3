"""Scores of populations, alarms of those whose seal is sound, and what nuisances do to healthy scores."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.evaluation.sensitivity import Reach
from hydrofdi.report.detection.populations import (
    TOGETHER,
    end,
    foremost_nuisances,
    shown_nuisances,
    tested_range,
)
from hydrofdi.report.detection.wording import (
    SeverityUnit,
    chosen_levels,
    foremost,
    sensors,
    severity_unit,
    tested,
)
from hydrofdi.report.figures.detection.marks import (
    panels,
    root_percent_axis,
    sensor_marks,
    titled,
    with_threshold,
)
from hydrofdi.report.figures.style import BLUE, GREEN, INK, ORANGE, PAPER, PINK
from hydrofdi.settings.readable import readable_unit, two_digits
from hydrofdi.studies.records import Detection, Judgement
from hydrofdi.units import convert

_MOST, _MOST_LEVELS, _EDGE = 6, 7, 0.5
_MOST_BINS, _WIDEST = 60, 6.0
"""Bins of many records, and how far beyond the healthy scores a population may begin, in widths of these."""

_LEAST_OF_HEALTHY = 8.0
"""Bins of the healthy scores, if all others leave room."""

_COLORS = {Kind.HEALTHY: BLUE, Kind.SHIFT: GREEN, Kind.CONFUSION: PINK, Kind.FAULT: ORANGE}


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
    figure, axes = panels(len(shown), 3, width=3.0, height=height, sharey=True)
    for axis, judgement in zip(axes, shown, strict=True):
        _draw_one(axis, detection, judgement, populations)
        axis.set_title(titled(judgement), fontsize=8.5)
    rows = range(len(populations))
    axes[0].set_yticks(rows, [_label(each) for each in populations], fontsize=8)
    axes[0].set_ylim(len(populations) - 0.8, -1.1)
    return figure


def _populations(detection: Detection) -> tuple[Population, ...]:
    """Healthy, shifted and confused ones, and some of the leaking ones."""
    sound, chosen = (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION), chosen_levels(detection, _MOST_LEVELS)
    populations = detection.records.populations
    return tuple(each for each in populations if each.kind in sound or each in chosen)


def _draw_one(
    axis: Any, detection: Detection, judgement: Judgement, populations: tuple[Population, ...]
) -> None:
    scores = [judgement.scored.values[detection.records.rows(each)] for each in populations]
    scores = [own[np.isfinite(own)] for own in scores]
    healthy = [own for own, each in zip(scores, populations, strict=True) if each.kind is Kind.HEALTHY]
    edges = _edges(_limits(judgement), healthy, scores)
    unit = readable_unit(judgement.scored.unit, float(np.abs(edges).max()))
    scale = 1.0 if unit == judgement.scored.unit else convert(1.0, unit)
    for row, (population, own) in enumerate(zip(populations, scores, strict=True)):
        counts, _ = np.histogram(own, edges)
        if counts.any():
            ridge, color = row - 0.95 * counts / counts.max(), _COLORS[population.kind]
            axis.stairs(ridge, edges * scale, baseline=row, fill=True, color=color, alpha=0.35)
            axis.stairs(ridge, edges * scale, baseline=row, color=color, linewidth=0.7)
        _draw_beyond(axis, row, own, edges)
    for limit in _limits(judgement):
        axis.axvline(limit * scale, color=INK, linewidth=0.9)
    axis.set_xlim(edges[0] * scale, edges[-1] * scale)
    axis.set_xlabel("score" if unit == "1" else f"score [{unit}]", fontsize=8)
    axis.locator_params(axis="x", nbins=4)
    axis.ticklabel_format(axis="x", useOffset=False)


def _draw_beyond(axis: Any, row: int, own: Array, edges: Array) -> None:
    """Shares of the scores beyond either end of the axis, as numbers with an arrow."""
    for is_beyond, place, side, text in (
        (own < edges[0], 0.01, "left", "← {:.0f} %"),
        (own > edges[-1], 0.99, "right", "{:.0f} % →"),
    ):
        if own.size and 100.0 * is_beyond.mean() >= 2.0 * _EDGE:
            axis.text(
                place, row - 0.15, text.format(100.0 * is_beyond.mean()), ha=side, fontsize=7,
                transform=axis.get_yaxis_transform(),
            )  # fmt: skip


def _label(population: Population) -> str:
    is_named = not population.is_fit or "fit" in population.name
    return population.name if is_named else f"{population.name} (fit)"


def _limits(judgement: Judgement) -> list[float]:
    threshold = judgement.threshold
    ends = () if threshold is None else (threshold.low, threshold.high)
    return [end for end in ends if np.isfinite(end)]


def _edges(limits: list[float], healthy: list[Array], scores: list[Array]) -> Array:
    """Edges of the bins: whole populations, but for the rarest scores, if the healthy ones remain visible."""
    near = _span(limits, healthy)
    reach = _WIDEST * (near[1] - near[0]) or max(abs(near[1]), 1.0)
    spans = [near, *(_span([], [own]) for own in scores if own.size)]
    seen = [each for each in spans if each[0] <= near[1] + reach and each[1] >= near[0] - reach]
    low = max(min(each[0] for each in seen), near[0] - 1.5 * reach)
    high = min(max(each[1] for each in seen), near[1] + 1.5 * reach)
    margin = 0.03 * (high - low) or 0.5 * reach
    n_record = np.median([own.size for own in scores])
    least = _LEAST_OF_HEALTHY * _WIDEST * (high - low) / reach
    count = int(np.clip(max(2.5 * np.sqrt(n_record), least), 12, _MOST_BINS))
    return np.linspace(low - margin, high + margin, count + 1)


def _span(limits: list[float], scores: list[Array]) -> tuple[float, float]:
    """Ends of all but the rarest scores, which are one in two hundred at either end."""
    filled = [own for own in scores if own.size]
    ends = [*limits, *(np.percentile(own, _EDGE, method="lower") for own in filled)]
    ends += [np.percentile(own, 100.0 - _EDGE, method="higher") for own in filled]
    return (float(min(ends)), float(max(ends))) if ends else (0.0, 1.0)


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
    figure, axes = panels(len(shown), 3, width=3.0, height=height, sharex=True, sharey=True)
    rates = [rate for each in shown for one, rate in each.false_alarms.items() if one in populations]
    highest = max([2.0 * detection.rules.false_alarm_rate, *(rate.high for rate in rates if rate.total)])
    for axis, judgement in zip(axes, shown, strict=True):
        root_percent_axis(axis, 100.0 * highest)
        for row, population in enumerate(populations):
            _draw_rate(axis, row, judgement, population, marks[sensors(judgement)])
        axis.axvline(100.0 * detection.rules.false_alarm_rate, color=INK, linewidth=0.9)
        axis.set_title(titled(judgement), fontsize=8.5)
    axes[0].set_yticks(range(len(populations)), [population.name for population in populations], fontsize=8)
    axes[0].set_ylim(len(populations) - 0.4, -0.6)
    figure.supxlabel("records that raise an alarm [%]", fontsize=9)
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


_MOST_PANELS, _MOST_NUISANCES = 6, 8
_STUB, _START = 0.12, 0.3
"""Decades: length of a bar that stays below the tested leaks, and where these begin."""


def draw_tornado(detection: Detection) -> Any:
    """Leaks that each nuisance imitates (right) and hides (left), a panel for each score.

    Raises
    ------
    ReportError
        The study has no records for it, or no leak moves a score.
    """
    tested, unit = tested_range(detection), severity_unit(detection)
    shown = [
        (name, [(label, reach) for label, _, reach in foremost_nuisances(own, _MOST_NUISANCES) if reach])
        for name, own in shown_nuisances(detection)
        if own.together
    ][:_MOST_PANELS]
    if tested is None or not shown:
        raise ReportError("no nuisance can be expressed as a leak: set study.sensitivity.alone, and leaks")
    height = 0.9 + 0.2 * max(len(rows) for _, rows in shown)
    figure, axes = panels(len(shown), 2, width=4.4, height=height)
    for axis, (name, rows) in zip(axes, shown, strict=True):
        _draw_reach(axis, name, rows, tested)
        _ticks(axis, tested, unit)
    figure.supxlabel(
        f"← {unit.quantity} that is hidden          {unit.quantity} that a healthy record looks like →"
        f"  {unit.bracket}",
        fontsize=9,
    )
    return figure


def _draw_reach(axis: Any, name: str, rows: Sequence[tuple[str, Reach]], tested: tuple[float, float]) -> None:
    for row, (label, reach) in enumerate(rows):
        for sign, fault, color in ((1.0, reach.imitated, ORANGE), (-1.0, reach.hidden, BLUE)):
            faded = 0.45 if label == TOGETHER else 0.9
            axis.barh(row, sign * _decades(end(fault), tested), height=0.62, color=color, alpha=faded)
            ends = [sign * _decades(limit, tested) for limit in (fault.low, fault.high)]
            axis.plot(ends, [row, row], color=INK, linewidth=0.8)
    axis.set_yticks(range(len(rows)), [label for label, _ in rows], fontsize=7.5)
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.axvline(0.0, color=INK, linewidth=0.6)
    axis.grid(visible=False, axis="y")
    axis.set_title(name, fontsize=8.5)


def _decades(severity: float, tested: tuple[float, float]) -> float:
    """Decades from where the tested leaks begin; what is smaller or larger than these lies outside."""
    if severity == 0.0:
        return _STUB
    end = _START + math.log10(tested[1] / tested[0])
    return min(_START + math.log10(severity / tested[0]), end) if math.isfinite(severity) else end + _START


def _ticks(axis: Any, tested: tuple[float, float], unit: SeverityUnit) -> None:
    first, last = map(unit.value, tested)
    decades = range(math.ceil(math.log10(first) - 1e-9), math.floor(math.log10(last) + 1e-9) + 1)
    severities = [10.0**decade / unit.value(1.0) for decade in decades]
    places = [(_decades(severity, tested), two_digits(unit.value(severity))) for severity in severities]
    marks = [(sign * place, text) for place, text in places for sign in (-1.0, 1.0)]
    axis.set_xticks([place for place, _ in marks], [text for _, text in marks])
    widest = _decades(math.inf, tested)
    axis.set_xlim(-widest - 0.05, widest + 0.05)
    for place in (-_START, _START, _START - widest, widest - _START):
        axis.axvline(place, color=INK, linewidth=0.4, linestyle=":")
