"""Panels of scores: their values in each population, and alarms of those whose seal is sound."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.scores import Array, Kind, Population
from hydrofdi.report.detection.wording import chosen_levels, foremost, sensors, tested
from hydrofdi.report.figures import style
from hydrofdi.settings.readable import readable_unit, typeset
from hydrofdi.studies.records import Detection, Judgement
from hydrofdi.units import convert

_MOST, _MOST_LEVELS, _EDGE = 6, 7, 0.5
_MOST_BINS, _WIDEST = 60, 6.0
"""Bins of many records, and how far beyond the healthy scores a population may begin, in widths of these."""

_LEAST_OF_HEALTHY = 8.0
"""Bins of the healthy scores, if all others leave room."""

_COLORS = {
    Kind.HEALTHY: style.BLUE,
    Kind.SHIFT: style.GREEN,
    Kind.CONFUSION: style.PINK,
    Kind.FAULT: style.ORANGE,
}


def sensor_marks(detection: Detection, shown: Sequence[Judgement]) -> dict[str, dict[str, Any]]:
    """Sets of sensors of the shown scores → colour and marker, which are the same in all figures.

    The largest set of the study comes first; all beyond seven have the last mark.
    """
    found = {sensors(each): len(each.scored.channels) for each in detection.judgements}
    ordered = sorted(found, key=lambda name: (-found[name], name))
    last = len(style.COLORS) - 1
    return {
        name: {"color": style.COLORS[min(index, last)], "marker": style.MARKERS[min(index, last)]}
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
    figure, axes = style.panels(len(shown), 3, width=3.0, height=height, sharey=True, **more)
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
        _draw_one(axis, detection, judgement, populations)
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
        axis.axvline(limit * scale, color=style.INK, linewidth=0.9)
    axis.set_xlim(edges[0] * scale, edges[-1] * scale)
    axis.set_xlabel("score" if unit == "1" else f"score [{typeset(unit)}]", fontsize=8)
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
    figure, axes = score_panels(shown, height, sharex=True, x="records that raise an alarm [%]")
    rates = [rate for each in shown for one, rate in each.false_alarms.items() if one in populations]
    highest = max([2.0 * detection.rules.false_alarm_rate, *(rate.high for rate in rates if rate.total)])
    for axis, judgement in zip(axes, shown, strict=True):
        style.root_percent_axis(axis, 100.0 * highest)
        for row, population in enumerate(populations):
            _draw_rate(axis, row, judgement, population, marks[sensors(judgement)])
        axis.axvline(100.0 * detection.rules.false_alarm_rate, color=style.INK, linewidth=0.9)
    style.row_axis(axes[0], [population.name for population in populations])
    return figure


def _draw_rate(
    axis: Any, row: int, judgement: Judgement, population: Population, mark: dict[str, Any]
) -> None:
    rate = judgement.false_alarms.get(population)
    if rate is None or not rate.total:
        return
    face = {"markerfacecolor": style.PAPER} if population in judgement.counted else {}
    axis.plot([100.0 * rate.low, 100.0 * rate.high], [row, row], color=mark["color"], linewidth=1.2)
    axis.plot(100.0 * rate.value, row, **mark, **face, markersize=5, linestyle="none", clip_on=False)
