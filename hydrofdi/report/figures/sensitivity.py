"""Heat map of δ over leakage, EBM and level against both baselines."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import group_breaks
from hydrofdi.report.figures.style import BLACK
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.report.sections.changes import BASELINES, baseline_title
from hydrofdi.report.wording import delta_cells, leakage_label, megapascal, other_conditions

_LIMIT, _STRONG = 60.0, 30.0
"""Ends of the colour scale, and from where on white letters read better [%]."""

_MOST_ROWS = 48

_TITLE, _LABEL = 48, 24
"""Letters that fit on a line over a panel, and beside it; longer labels widen the figure."""


def draw_sensitivity(analysis: Analysis) -> Figure:
    """δ of all levels; the sealed control rows stand on top."""
    table = analysis.table
    rows = table.rows[:_MOST_ROWS]
    beside = max(len(_row_label(row)) for row in rows) - _LABEL
    size = (9.0 + 0.08 * max(0, beside), 1.5 + 0.32 * len(rows))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(1, len(BASELINES), sharey=True)
    for axis, (baseline, delta) in zip(axes, BASELINES.items(), strict=True):
        image = _draw_baseline(axis, rows, [delta(row) for row in rows])
        _head(axis, table, baseline)
    axes[0].set_yticks(range(len(rows)), [_row_label(row) for row in rows], fontsize=8)
    if len(rows) < len(table.rows):
        figure.supxlabel(f"the first {len(rows)} of {len(table.rows):,} rows", fontsize=8)
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.7, pad=0.02)
    bar.set_label("δ [%]; framed: largest positive of the row")
    bar.outline.set_visible(False)
    return figure


def _draw_baseline(axis: Any, rows: tuple[TableRow, ...], deltas: list[tuple[float, ...]]) -> Any:
    values = np.array(deltas)
    image = axis.imshow(values, cmap="PuOr_r", vmin=-_LIMIT, vmax=_LIMIT, aspect="auto")
    for y, levels in enumerate(deltas):
        for x, cell in enumerate(delta_cells(levels)):
            color = "#ffffff" if abs(values[y, x]) > _STRONG else BLACK
            axis.text(x, y, cell.text, ha="center", va="center", fontsize=8, color=color)
            if cell.is_strong:
                axis.add_patch(_frame(x, y))
    for position in group_breaks([row.leakage_request for row in rows]):
        axis.axhline(position - 0.5, color=BLACK, linewidth=2.0 if rows[position - 1].is_sealed else 0.6)
    return image


def _frame(x: int, y: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x - 0.46, y - 0.42), 0.92, 0.84, fill=False, edgecolor=BLACK, linewidth=1.3)


def _head(axis: Any, table: SensitivityTable, baseline: str) -> None:
    axis.grid(visible=False)
    axis.set_xticks(range(table.n_level), [f"$d_{level}$" for level in range(1, table.n_level + 1)])
    axis.xaxis.tick_top()
    kind, _, against = baseline_title(table, baseline).partition(" against ")
    axis.set_title(f"{kind} against\n{fill(against, _TITLE)}")
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _row_label(row: TableRow) -> str:
    unit = "" if row.is_sealed else " L/min"
    mode = f"{leakage_label(row)}{unit}, {megapascal(row.bulk_modulus)} MPa"
    return ", ".join(filter(None, [mode, other_conditions(row)]))
