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
from hydrofdi.settings.messages import readable_unit, typeset
from hydrofdi.studies.records import Detection, Judgement
from hydrofdi.units import convert

_MOST, _MOST_LEVELS = 6, 7
_N_BIN, _WIDEST = 50, 4.0
"""Bins, and how far beyond the healthy scores they reach, in widths of these."""

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
    ends = () if judgement.threshold is None else (judgement.threshold.low, judgement.threshold.high)
    limits = [end for end in ends if np.isfinite(end)]
    edges = _edges(np.concatenate([limits, *healthy]), np.concatenate(scores))
    unit = readable_unit(judgement.scored.unit, float(np.abs(edges).max()))
    scale = 1.0 if unit == judgement.scored.unit else convert(1.0, unit)
    for row, (population, own) in enumerate(zip(populations, scores, strict=True)):
        # Scores beyond either end stand in the last bin there.
        counts, _ = np.histogram(np.clip(own, edges[0], edges[-1]), edges)
        if counts.any():
            ridge, color = row - 0.95 * counts / counts.max(), _COLORS[population.kind]
            axis.stairs(ridge, edges * scale, baseline=row, fill=True, color=color, alpha=0.35)
            axis.stairs(ridge, edges * scale, baseline=row, color=color, linewidth=0.7)
    for limit in limits:
        axis.axvline(limit * scale, color=style.INK, linewidth=0.9)
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
