"""How scores are distinguished, and axes of rates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydrofdi.errors import ReportError
from hydrofdi.evaluation.scores import Array
from hydrofdi.report.detection.wording import foremost, sensors
from hydrofdi.report.figures.style import COLORS, MARKERS
from hydrofdi.studies.records import Detection, Judgement

_TICKS = (0.001, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 0.999)

_PERCENT = (0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 75.0, 100.0)


def deviates(rates: Array, least: float) -> Array:
    """Φ⁻¹ of rates, those of 0 and 1 drawn at the ends of the axis."""
    from scipy.special import ndtri

    return np.asarray(ndtri(np.clip(rates, least, 1.0 - least)))


def normal_deviate_axis(axis: Any, least: float) -> None:
    """Show percent on an axis of normal deviates, from `least` to 1 - `least`."""
    ticks = np.array([tick for tick in _TICKS if least <= tick <= 1.0 - least])
    axis.set_ticks(deviates(ticks, least), [f"{100.0 * tick:g}" for tick in ticks])
    low, high = deviates(np.array([least, 1.0 - least]), least)
    axis.axes.set(**{f"{axis.axis_name}lim": (low - 0.08, high + 0.08)})


def root_percent_axis(axes: Any, highest: float) -> None:
    """A horizontal axis of percent, whose scale is the square root, so that small rates can be read."""
    end = min(1.15 * highest, 100.0)
    ticks = [0.0]
    for tick in _PERCENT:
        if tick <= end and np.sqrt(tick) - np.sqrt(ticks[-1]) > 0.1 * np.sqrt(end):
            ticks.append(tick)
    axes.set_xscale("function", functions=(lambda x: np.sqrt(np.maximum(x, 0.0)), np.square))
    axes.set_xlim(0.0, end)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()


def sensor_marks(detection: Detection, shown: Sequence[Judgement]) -> dict[str, dict[str, Any]]:
    """Sets of sensors of the shown scores → colour and marker, which are the same in all figures.

    The largest set of the study comes first; all beyond seven have the last mark.
    """
    found = {sensors(each): len(each.scored.channels) for each in detection.judgements}
    ordered = sorted(found, key=lambda name: (-found[name], name))
    last = len(COLORS) - 1
    return {
        name: {"color": COLORS[min(place, last)], "marker": MARKERS[min(place, last)]}
        for place, name in enumerate(ordered)
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


def panels(
    count: int, columns: int, *, width: float, height: float, x: str = "", y: str = "", **shared: Any
) -> tuple[Any, list[Any]]:
    """A figure with `count` panels in rows, and the panels; `x` and `y` are labels of all of them."""
    columns = min(count, columns)
    rows = -(-count // columns)
    figure = Figure(figsize=(max(width * columns, 9.0), height * rows + 0.4), layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False, **shared).flat)
    for axis in axes[:count]:
        axis.tick_params(labelsize=7.5)
    for axis in axes[count:]:
        axis.remove()
    if x:
        figure.supxlabel(x, fontsize=9)
    if y:
        figure.supylabel(y, fontsize=9)
    return figure, axes[:count]


def score_panels(shown: Sequence[Judgement], height: float, **more: Any) -> tuple[Any, list[Any]]:
    """A figure with a panel for each score."""
    figure, axes = panels(len(shown), 3, width=3.0, height=height, sharey=True, **more)
    for axis, judgement in zip(axes, shown, strict=True):
        axis.set_title(_titled(judgement), fontsize=8.5)
    return figure, axes


def legend_outside(figure: Any, styles: Mapping[str, Mapping[str, Any]], ncols: int, title: str = "") -> None:
    """A legend above all panels: label → style of a line."""
    handles = [Line2D([], [], label=label, **style) for label, style in styles.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=ncols, title=title or None)


def row_axis(axis: Any, labels: Sequence[str], fontsize: float = 8) -> None:
    """Rows with their names, the first one on top."""
    axis.set_yticks(range(len(labels)), labels, fontsize=fontsize)
    axis.set_ylim(len(labels) - 0.4, -0.6)
