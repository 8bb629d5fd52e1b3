"""Heat map of δ over varied parameters and levels, against each baseline."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.changes import baseline_title, delta_of
from hydrofdi.report.document import group_breaks
from hydrofdi.report.figures.style import INK
from hydrofdi.report.runs import Levels, RunTable, largest_positive
from hydrofdi.report.wording import lead_columns, signed

_COLORS, _MISSING = "PuOr_r", "#e4e4e8"
"""Scale of δ, and a run without numbers."""

_WHITE, _BLACK = "#ffffff", "#000000"

_LIMITS = (10.0, 30.0, 60.0)
"""Ends that the colour scale may have [%]."""

_CELL, _LETTER, _FONT = 0.62, 0.066, 8
"""Widths of a cell and of a letter beside it [in], and its size [pt]."""

_FRAMED = "Framed: largest positive δ of the row"


@dataclass(frozen=True)
class HeatLines:
    """The columns beside the cells of the heat map, and the cells.

    Attributes
    ----------
    headers : tuple of str
        Above the columns beside the cells, with units.
    texts : tuple of tuple of str
        These columns, line by line.
    changes : dict
        Kind of baseline → δ of each level [%], line by line.
    breaks, strong_breaks : tuple of int
        Lines with a thin or a thick rule above them.
    """

    headers: tuple[str, ...]
    texts: tuple[tuple[str, ...], ...]
    changes: dict[str, list[Levels]]
    breaks: tuple[int, ...]
    strong_breaks: tuple[int, ...]


def heat_lines(analysis: Analysis) -> HeatLines:
    """One line per run."""
    rows = analysis.table.rows
    leakage, *others = lead_columns(analysis.table, rows)
    shown = [leakage, *(each for each in others if len({*map(each.text_of, range(len(rows)))}) > 1)]
    breaks = group_breaks([row.leakage_request for row in rows])
    return HeatLines(
        tuple(column.heading for column in shown),
        tuple(tuple(column.text_of(place) for column in shown) for place in range(len(rows))),
        {name: [*map(delta_of("details", name), rows)] for name in analysis.baselines},
        breaks,
        tuple(place for place in breaks if rows[place - 1].is_sealed),
    )


def draw_sensitivity(analysis: Analysis) -> Figure:
    """δ of all levels; the sealed control rows are on top.

    Raises
    ------
    ReportError
        δ is not known, or zero for every run by construction.
    """
    table, baselines = analysis.table, analysis.baselines
    if not baselines:
        raise ReportError(analysis.missing_baseline or analysis.no_changes)
    lines = heat_lines(analysis)
    widths = _column_widths(lines)
    panel = max(_CELL * table.n_level, 2.9)
    beside = _LETTER * sum(widths)
    n_line = len(lines.texts)
    size = (beside + len(baselines) * panel + 1.3, 1.9 + (0.3 if n_line <= 30 else 0.22) * n_line)
    figure = Figure(figsize=size, layout="constrained")
    widths_of_all = (beside, *(panel for _ in baselines))
    left, *axes = figure.subplots(1, len(widths_of_all), sharey=True, width_ratios=widths_of_all)
    limit = _limit(lines)
    for axis, baseline in zip(axes, baselines, strict=True):
        image = _draw_cells(axis, lines.changes[baseline], limit)
        _draw_rules(axis, lines)
        _head(axis, table, baseline, round(panel / 0.078))
    _draw_beside(left, lines, widths)
    figure.supxlabel(_FRAMED, fontsize=_FONT, x=0.01, ha="left")
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.8, pad=0.02, aspect=max(8, n_line))
    bar.set_label("δ [%]")
    bar.outline.set_visible(False)
    return figure


def _limit(lines: HeatLines) -> float:
    """End of the colour scale that contains most changes."""
    values = np.abs(np.concatenate([np.ravel(levels) for levels in lines.changes.values()]))
    values = values[np.isfinite(values)]
    largest = float(np.quantile(values, 0.95)) if values.size else 0.0
    return next((limit for limit in _LIMITS if largest <= limit), _LIMITS[-1])


def _draw_cells(axis: Any, deltas: Any, limit: float) -> Any:
    import matplotlib

    values = np.array(deltas)
    colors = matplotlib.colormaps[_COLORS].with_extremes(bad=_MISSING)
    image = axis.imshow(values, cmap=colors, vmin=-limit, vmax=limit, aspect="auto")
    for y, levels in enumerate(deltas):
        best = largest_positive(levels)
        for x, text in enumerate(map(signed, levels)):
            light = np.dot(image.to_rgba(values[y, x : x + 1])[0, :3], (0.299, 0.587, 0.114))
            color = _BLACK if light > 0.5 or not np.isfinite(values[y, x]) else _WHITE
            axis.text(x, y, text, ha="center", va="center", fontsize=_FONT, color=color)
            if x == best and text != "0.0":
                axis.add_patch(_frame(x, y))
    return image


def _frame(x: int, y: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x - 0.46, y - 0.42), 0.92, 0.84, fill=False, edgecolor=_BLACK, linewidth=1.3)


def _draw_rules(axis: Any, lines: HeatLines) -> None:
    for place in sorted({*lines.breaks, *lines.strong_breaks}):
        axis.axhline(place - 0.5, color=_BLACK, linewidth=2.0 if place in lines.strong_breaks else 0.6)


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


def _column_widths(lines: HeatLines) -> list[int]:
    """Letters of the columns beside the cells."""
    columns = zip(*lines.texts, strict=True)
    return [
        2 + max(map(len, (*column, *_broken(header).split("\n"))))
        for header, column in zip(lines.headers, columns, strict=True)
    ]


def _broken(header: str) -> str:
    """A header on separate lines: section, parameter, unit."""
    return header.replace(".", ".\n").replace(" [", "\n[")


def _draw_beside(axis: Any, lines: HeatLines, widths: list[int]) -> None:
    """What each line is, in columns."""
    ends = np.cumsum(widths)
    axis.set_xlim(0.0, ends[-1])
    axis.set_xticks(ends - 1.0, [_broken(header) for header in lines.headers], fontsize=_FONT, ha="right")
    for y, texts in enumerate(lines.texts):
        for end, text in zip(ends, texts, strict=True):
            axis.text(end - 1.0, y, text, ha="right", va="center", fontsize=_FONT, color=INK)
    for place in lines.breaks:
        axis.axhline(place - 0.5, color=INK, linewidth=0.6)
    _bare(axis)
    axis.tick_params(axis="x", labelsize=_FONT)
