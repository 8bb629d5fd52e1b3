"""Heat maps of features over two parameters, one panel each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.config.runs import spread
from hydrofdi.report.figures.style import INK
from hydrofdi.report.plane import Plane
from hydrofdi.report.responses import Array, Feature
from hydrofdi.report.wording import signed
from hydrofdi.settings.readable import number_text

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
        places = spread(len(texts), _MOST_TICKS)
        getattr(panels[0, 0], f"set_{axis}ticks")(places, [texts[place] for place in places])
        getattr(figure, f"sup{axis}label")(header, fontsize=9)
    marked = "framed or starred: the healthy baseline" if plane.baseline is not None else ""
    figure.suptitle("; ".join(filter(None, (plane.said, marked))), fontsize=8, x=0.01, ha="left")
    return figure


def _limit(changes: list[Array]) -> float:
    """End of the colour scale that contains most changes."""
    values = np.abs(np.concatenate([each[np.isfinite(each)] for each in changes]))
    largest = float(np.quantile(values, 0.95)) if values.size else 0.0
    return next((limit for limit in _LIMITS if largest <= limit), _LIMITS[-1])


def _draw(panel: Any, feature: Feature, matrix: Array, limit: float) -> Any:
    import matplotlib

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
    from matplotlib.patches import Rectangle

    if row.is_integer() and column.is_integer():
        corner = column - 0.5, row - 0.5
        panel.add_patch(Rectangle(corner, 1.0, 1.0, fill=False, linewidth=1.4, edgecolor=INK, clip_on=False))
    else:
        panel.plot(column, row, "*", color=_WHITE, markeredgecolor=INK, markersize=9, clip_on=False)
