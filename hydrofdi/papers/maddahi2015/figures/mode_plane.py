"""The plane of f_h and ζ: EBM moves along one axis, leakage along the other."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.grid.modes import ABSENT
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.style import INK, MARKERS, RULE, series
from hydrofdi.report.wording import litres_per_minute, shown_modulus
from hydrofdi.store.layout import names

_NAMED = 14
"""EBM that have room side by side."""


def draw_mode_plane(study: Study) -> Figure:
    """The hydraulic mode of every run, linearised at its median working point."""
    grid, columns = study.grid, study.data.columns
    positions = grid.positions[0]
    frequency = _picked(columns[names.MODE_FREQUENCY], positions)
    damping = _picked(columns[names.MODE_DAMPING_RATIO], positions)
    if np.isnan(frequency).all():
        raise ReportError("no run succeeded")
    figure = Figure(figsize=(7.4, 4.2), layout="constrained")
    axis = figure.subplots()
    axis.plot(frequency, damping, color=RULE, linewidth=1.2, zorder=1)
    for row in range(len(positions)):
        style = series(row, len(positions))
        flow = 0.0 if row == 0 else grid.leakage_flows[row - 1]
        name = f"{litres_per_minute(flow)} L/min" if flow else "sealed"
        axis.plot(
            frequency[row], damping[row], **style, linewidth=0.9, marker=MARKERS[row % len(MARKERS)],
            markerfacecolor="none" if row == 0 else style["color"], label=name,
        )  # fmt: skip
    _name_bulk_moduli(axis, study, frequency, damping)
    _mark_borders(axis, study, frequency)
    axis.set_xlabel("frequency of the hydraulic mode $f_h$ [Hz]")
    axis.set_ylabel("damping ratio ζ [–]")
    axis.legend(
        title=f"leakage; numbers: EBM [{shown_modulus().unit}]", loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )
    return figure


def _picked(values: Any, positions: Any) -> Any:
    return np.where(positions == ABSENT, np.nan, values[positions])


def _name_bulk_moduli(axis: Any, study: Study, frequency: Any, damping: Any) -> None:
    apart, last = np.ptp(frequency[np.isfinite(frequency)]) / _NAMED, -np.inf
    for column, beta in enumerate(study.grid.bulk_moduli):
        known = ~np.isnan(damping[:, column])
        if known.any() and frequency[known, column][0] >= last + apart:
            last = frequency[known, column][0]
            top = damping[known, column].max()
            at = (frequency[known, column][0], top)
            axis.annotate(
                shown_modulus().text(beta), at, (0, 8), textcoords="offset points", ha="center", fontsize=8
            )
    axis.margins(0.12, 0.15)


def _mark_borders(axis: Any, study: Study, frequency: Any) -> None:
    """The borders of the wavelet bands that the modes lie near."""
    low, high = np.nanmin(frequency), np.nanmax(frequency)
    for level, (_, border) in enumerate(study.table.bands, 1):
        if low * 0.9 < border < high * 1.1 and level > 1:
            axis.axvline(border, color=INK, linewidth=0.8, linestyle=":")
            axis.text(
                border, 1.01, f" $d_{level}$ | $d_{level - 1}$ ", transform=axis.get_xaxis_transform(),
                ha="center", va="bottom", color=INK,
            )  # fmt: skip
