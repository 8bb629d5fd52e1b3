"""Figures of any sweep: each feature over each varied parameter, and heat maps over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from textwrap import fill
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from hydrofdi.config.runs import spread
from hydrofdi.report.figures import BLUE, INK, log_axis
from hydrofdi.report.responses import AGAINST, RANGES, ResponseStudy, RunFeature, VariedParameter
from hydrofdi.report.runs import Array, signed
from hydrofdi.report.views import Plane
from hydrofdi.settings.messages import number_text
from hydrofdi.tables.table import folded

_MOST_AXES, _MOST_FEATURES = 6, 8
_WIDTH, _HEIGHT = 2.4, 1.25
_LABEL, _LETTERS = 7.5, 20
"""Size of the labels of features [pt], and the letters of it in a panel."""

_DECADES = 30.0
"""An axis is logarithmic if the ratio of its values is at least this."""


def draw_responses(study: ResponseStudy) -> Figure:
    """A row for each feature, a column for each parameter."""
    responding = [axis for axis in study.axes if axis.responses]
    reaches = {each.name: max(one.reach for one in each.responses) for each in responding}
    chosen = _largest(reaches, _MOST_AXES)
    axes = [axis for axis in responding if axis.name in chosen]
    moved: dict[str, float] = {}
    for one in (one for axis in axes for one in axis.responses):
        name = one.feature.header
        moved[name] = max(one.reach, moved.get(name, 0.0))
    shown = _largest(moved, _MOST_FEATURES)
    size = (max(_WIDTH * len(axes) + 0.8, 5.0), _HEIGHT * len(shown) + 1.6)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(shown), len(axes), sharex="col", sharey="row", squeeze=False)
    for column, each in enumerate(axes):
        _draw_column(grid[:, column], each, shown)
    for panel, name in zip(grid[:, 0], shown, strict=True):
        panel.set_ylabel(_label(name), fontsize=_LABEL)
    figure.align_ylabels(grid[:, 0])
    note = fill(_note(axes, len(responding), len(shown), len(moved)), round(size[0] / 0.068))
    figure.supxlabel(note, fontsize=8, x=0.01, ha="left")
    return figure


def _label(name: str) -> str:
    """The name and unit of a feature on lines that are no longer than a panel is high."""
    words, _, unit = (name if "[" in name else f"{name} [–]").partition(" [")
    return "\n".join([*folded(words, _LETTERS), f"[{unit}"])


def _largest(sizes: Mapping[Any, float], most: int) -> list[Any]:
    """Those of the largest sizes, in their order."""
    chosen = sorted(sizes, key=lambda item: -sizes[item])[:most]
    return [item for item in sizes if item in chosen]


def _draw_column(panels: Any, axis: VariedParameter, shown: Sequence[str]) -> None:
    positions, labels = _places(axis)
    by_name = {one.feature.header: one for one in axis.responses}
    for panel, name in zip(panels, shown, strict=True):
        if name in by_name:
            over = by_name[name].over
            low, high = [spread.low for spread in over], [spread.high for spread in over]
            panel.fill_between(positions, low, high, color=BLUE, alpha=0.2, linewidth=0)
            panel.plot(positions, [spread.median for spread in over], color=BLUE, marker="o", markersize=3.5)
    _mark_values(panels[-1], positions, labels)
    panels[-1].set_xlabel(axis.header if "[" in axis.header or labels else f"{axis.header} [–]")
    if axis.against:
        panels[0].set_title(fill(f"δ against {AGAINST[axis.against]}", 32), fontsize=8)


def _places(axis: VariedParameter) -> tuple[list[float], list[str]]:
    """Where the groups stand, and their names where they are words, or reach from nothing over decades."""
    count = [float(index) for index in range(len(axis.groups))]
    if axis.numbers is None:
        return count, [group.text for group in axis.groups]
    middles = [float(np.nanmedian(axis.numbers[group.rows])) for group in axis.groups]
    positions = [0.0 if middle == 0.0 else float(axis.text(middle)) for middle in middles]
    positive = [position for position in positions if position > 0.0]
    if positive and max(positive) >= _DECADES * min(positive) and len(positive) < len(positions):
        return count, [group.text for group in axis.groups]
    return positions, []


def _mark_values(panel: Any, positions: Sequence[float], labels: Sequence[str]) -> None:
    if labels:
        is_long = len(labels) * (2 + max(map(len, labels))) > 34
        panel.set_xticks(positions, labels, **({"rotation": 40, "ha": "right"} if is_long else {}))
        panel.margins(x=0.1)
    elif min(positions) > 0.0 and max(positions) >= _DECADES * min(positions):
        log_axis(panel.xaxis)
    else:
        panel.locator_params(axis="x", nbins=5)
        panel.xaxis.set_major_formatter("{x:g}")


def _note(axes: Sequence[VariedParameter], n_axis: int, n_feature: int, n_all: int) -> str:
    note = f"Line: median of the runs with this value; band: {RANGES}"
    if len(axes) < n_axis:
        note += f". Shown are the {len(axes)} of {n_axis} parameters that move a feature most"
    if n_feature < n_all:
        note += f". Shown are the {n_feature} of {n_all} features that move most; the tables have all"
    return note


_CHANGES, _VALUES, _MISSING = "PuOr_r", "viridis", "#e4e4e8"
"""Scales of changes and of other features, and a cell without numbers."""

_WHITE, _BLACK = "#ffffff", "#000000"
_LIMITS = (10.0, 30.0, 60.0, 100.0)
"""Ends that the colour scale of changes may have [%]."""
_MOST_PANELS, _PANELS_BESIDE, _MOST_TICKS, _MOST_NUMBERS = 6, 3, 5, 8


def draw_sensitivity(plane: Plane) -> Figure:
    """A panel for each change, with one scale of colours, else for each other feature."""
    shown = [each for each in plane.features if each.is_change == plane.features[0].is_change][:_MOST_PANELS]
    matrices = [plane.matrix(feature) for feature in shown]
    beside = min(len(shown), _PANELS_BESIDE)
    above = -(-len(shown) // beside)
    width, height = (min(max(0.44 * count + 0.9, 2.3), 3.6) for count in reversed(plane.shape))
    figure = Figure(figsize=(beside * width + 0.9, above * height + 0.5), layout="constrained")
    panels = figure.subplots(above, beside, sharex=True, sharey=True, squeeze=False)
    limit = _limit(matrices)
    for panel, feature, matrix in zip(panels.flat, shown, matrices, strict=False):
        image = _draw(panel, feature, matrix, limit)
        if not feature.is_change:
            figure.colorbar(image, ax=panel, pad=0.02).outline.set_visible(False)
        if plane.baseline is not None:
            _mark(panel, *plane.baseline)
    for panel in panels.flat[len(shown) :]:
        panel.set_axis_off()
    if shown[0].is_change:
        bar = figure.colorbar(image, ax=panels, extend="both", shrink=0.8, pad=0.02)
        bar.set_label("δ [%]")
        bar.outline.set_visible(False)
    for axis, texts, header in zip("yx", plane.texts, plane.headers, strict=True):
        ticks = spread(len(texts), _MOST_TICKS)
        getattr(panels[0, 0], f"set_{axis}ticks")(ticks, [texts[tick] for tick in ticks])
        getattr(figure, f"sup{axis}label")(header, fontsize=9)
    marked = "framed or starred: the healthy baseline" if plane.baseline is not None else ""
    figure.suptitle("; ".join(filter(None, (plane.said, marked))), fontsize=8, x=0.01, ha="left")
    return figure


def _limit(changes: list[Array]) -> float:
    """End of the colour scale that contains most changes."""
    values = np.abs(np.concatenate([each[np.isfinite(each)] for each in changes]))
    largest = float(np.quantile(values, 0.95)) if values.size else 0.0
    return next((limit for limit in _LIMITS if largest <= limit), _LIMITS[-1])


def _draw(panel: Any, feature: RunFeature, matrix: Array, limit: float) -> Any:
    colors = matplotlib.colormaps[_CHANGES if feature.is_change else _VALUES].with_extremes(bad=_MISSING)
    ends = {"vmin": -limit, "vmax": limit} if feature.is_change else {}
    image = panel.imshow(matrix, cmap=colors, aspect="auto", origin="lower", **ends)
    panel.set_title(feature.header)
    panel.grid(visible=False)
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    if matrix.shape[1] <= _MOST_NUMBERS and matrix.shape[0] <= 2 * _MOST_NUMBERS:
        number: Callable[[float], str] = signed if feature.is_change else number_text
        for y, x in np.ndindex(matrix.shape):
            light = np.dot(image.to_rgba(matrix[y, x : x + 1])[0, :3], (0.299, 0.587, 0.114))
            color = _BLACK if light > 0.5 or not np.isfinite(matrix[y, x]) else _WHITE
            panel.text(x, y, number(float(matrix[y, x])), ha="center", va="center", fontsize=7.5, color=color)
    return image


def _mark(panel: Any, row: float, column: float) -> None:
    """A frame about a cell, or a star between the values of the grid."""
    if row.is_integer() and column.is_integer():
        corner = column - 0.5, row - 0.5
        panel.add_patch(Rectangle(corner, 1.0, 1.0, fill=False, linewidth=1.4, edgecolor=INK, clip_on=False))
    else:
        panel.plot(column, row, "*", color=_WHITE, markeredgecolor=INK, markersize=9, clip_on=False)
