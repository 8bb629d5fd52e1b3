"""Heat map of δ over varied parameters and levels, against each baseline."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.report.changes import baseline_title
from hydrofdi.report.figures.style import INK
from hydrofdi.report.runs import Array, RunTable
from hydrofdi.report.table import Column, group_breaks
from hydrofdi.report.wording import delta_columns, lead_columns

if TYPE_CHECKING:
    from hydrofdi.report.composition import Report

_COLORS, _MISSING = "PuOr_r", "#e4e4e8"
"""Scale of δ, and a run without numbers."""

_WHITE, _BLACK = "#ffffff", "#000000"

_LIMITS = (10.0, 30.0, 60.0)
"""Ends that the colour scale may have [%]."""

_CELL, _LETTER, _FONT = 0.62, 0.066, 8
"""Widths of a cell and of a letter beside it [in], and its size [pt]."""

_FRAMED = "Framed: largest positive δ of the row"


def draw_sensitivity(report: Report) -> Figure:
    """δ of all levels; the sealed control rows are on top.

    Raises
    ------
    ReportError
        δ is not known, or zero for every run by construction.
    """
    table, baselines = report.table, report.baselines
    if not baselines:
        raise ReportError(report.no_changes)
    leakage, *others = lead_columns(table)
    shown = [leakage, *(each for each in others if len(set(_texts(each))) > 1)]
    widths = [2 + max(map(len, (*_texts(each), *_broken(each.heading).split("\n")))) for each in shown]
    breaks = group_breaks(table.leakage_requests.tolist())
    panel = max(_CELL * table.n_level, 2.9)
    beside = _LETTER * sum(widths)
    n_line = len(table)
    size = (beside + len(baselines) * panel + 1.3, 1.9 + (0.3 if n_line <= 30 else 0.22) * n_line)
    figure = Figure(figsize=size, layout="constrained")
    widths_of_all = (beside, *(panel for _ in baselines))
    left, *axes = figure.subplots(1, len(widths_of_all), sharey=True, width_ratios=widths_of_all)
    limit = _limit(np.stack([table.changes(baseline) for baseline in baselines]))
    for axis, baseline in zip(axes, baselines, strict=True):
        image = _draw_cells(axis, table.changes(baseline), limit)
        for place in breaks:
            axis.axhline(place - 0.5, color=_BLACK, linewidth=2.0 if table.is_sealed[place - 1] else 0.6)
        _head(axis, table, baseline, round(panel / 0.078))
    _draw_beside(left, shown, widths, breaks)
    figure.supxlabel(_FRAMED, fontsize=_FONT, x=0.01, ha="left")
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.8, pad=0.02, aspect=max(8, n_line))
    bar.set_label("δ [%]")
    bar.outline.set_visible(False)
    return figure


def _texts(column: Column) -> list[str]:
    return [*map(column.text_of, range(len(column.values)))]


def _limit(changes: Array) -> float:
    """End of the colour scale that contains most changes."""
    values = np.abs(changes[np.isfinite(changes)])
    largest = float(np.quantile(values, 0.95)) if values.size else 0.0
    return next((limit for limit in _LIMITS if largest <= limit), _LIMITS[-1])


def _draw_cells(axis: Any, values: Array, limit: float) -> Any:
    import matplotlib
    from matplotlib.patches import Rectangle

    colors = matplotlib.colormaps[_COLORS].with_extremes(bad=_MISSING)
    image = axis.imshow(values, cmap=colors, vmin=-limit, vmax=limit, aspect="auto")
    columns = delta_columns(values)
    for y, x in np.ndindex(values.shape):
        light = np.dot(image.to_rgba(values[y, x : x + 1])[0, :3], (0.299, 0.587, 0.114))
        color = _BLACK if light > 0.5 or not np.isfinite(values[y, x]) else _WHITE
        axis.text(x, y, columns[x].text_of(y), ha="center", va="center", fontsize=_FONT, color=color)
        if y in columns[x].strong:
            axis.add_patch(Rectangle((x - 0.46, y - 0.42), 0.92, 0.84, fill=False, linewidth=1.3))
    return image


def _head(axis: Any, table: RunTable, baseline: str, n_letter: int) -> None:
    axis.set_xticks(range(table.n_level), [f"$d_{level}$" for level in range(1, table.n_level + 1)])
    kind, _, against = baseline_title(table, baseline).partition(" against ")
    axis.set_title(f"{kind} against\n{fill(against, n_letter)}")
    _bare(axis)


def _bare(axis: Any) -> None:
    axis.grid(visible=False)
    axis.xaxis.tick_top()
    axis.tick_params(length=0, labelleft=False)
    axis.spines[:].set_visible(False)


def _broken(header: str) -> str:
    """A header on separate lines: section, parameter, unit."""
    return header.replace(".", ".\n").replace(" [", "\n[")


def _draw_beside(axis: Any, shown: list[Column], widths: list[int], breaks: Sequence[int]) -> None:
    """What each line is, in columns."""
    ends = np.cumsum(widths)
    axis.set_xlim(0.0, ends[-1])
    axis.set_xticks(ends - 1.0, [_broken(each.heading) for each in shown], fontsize=_FONT, ha="right")
    for y in range(len(shown[0].values)):
        for end, column in zip(ends, shown, strict=True):
            axis.text(end - 1.0, y, column.text_of(y), ha="right", va="center", fontsize=_FONT, color=INK)
    for place in breaks:
        axis.axhline(place - 0.5, color=INK, linewidth=0.6)
    _bare(axis)
    axis.tick_params(axis="x", labelsize=_FONT)
