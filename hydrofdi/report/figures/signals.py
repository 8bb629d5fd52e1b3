"""Signals of runs over time, in panels."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hydrofdi.report.figures.style import BLUE, INK, ORANGE
from hydrofdi.store import Columns
from hydrofdi.store.layout import names
from hydrofdi.transforms.wavelet import detail_coefficients
from hydrofdi.units import convert

PANELS = (
    (names.INPUT_VOLTAGE, "$u$ [V]", "V"),
    ("piston_position", "$x_p$ [mm]", "mm"),
    (names.CHAMBER_1_PRESSURE, "$P_1$ [MPa]", "MPa"),
    (names.CHAMBER_2_PRESSURE, "$P_2$ [MPa]", "MPa"),
    ("internal_leakage_flow", "$q_{il}$ [L/min]", "L/min"),
)

_MOVING_PANELS = (
    (names.VALVE_SUPPLY_PRESSURE, "$P_s$ [MPa]", "MPa"),
    (names.LOAD_FORCE, "$F_L$ [N]", "N"),
)
"""Shown if an option of the model makes them vary."""

Panels = tuple[tuple[str, str, str], ...]

Line = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Abscissae and ordinates."""


def draw_signals(columns: Columns, wavelet: Any, title: str) -> Figure:
    """Input, stroke, pressures, leakage flow and d2 of P_1 of a run over time, and other signals that vary.

    Parameters
    ----------
    columns : mapping
        Variables of one run, all signals included.
    wavelet : WaveletConfig
    title : str
    """
    panels = PANELS + tuple(panel for panel in _MOVING_PANELS if np.ptp(columns[panel[0]][0]) > 0.0)
    signals = {name: (columns[names.TIME], columns[name][0]) for name, _, _ in panels}
    figure = draw_panels(
        [panel_lines(panels, signals, wavelet)], [title], [BLUE], panel_labels(panels, wavelet)
    )
    draw_reference(
        stroke_axes(figure, 1)[0], columns[names.TIME], columns[names.REFERENCE_POSITION][0], ORANGE
    )
    return figure


def draw_beside(columns: Columns, titles: list[str], wavelet: Any) -> Figure:
    """The same signals of two runs beside each other."""
    time, references = columns[names.TIME], columns[names.REFERENCE_POSITION]
    lines = [
        panel_lines(PANELS, {name: (time, columns[name][row]) for name, _, _ in PANELS}, wavelet)
        for row in range(len(titles))
    ]
    figure = draw_panels(lines, titles, [BLUE, ORANGE], panel_labels(PANELS, wavelet))
    for axis, reference in zip(stroke_axes(figure, len(titles)), references, strict=True):
        draw_reference(axis, time, reference, INK)
    return figure


def stroke_axes(figure: Figure, n_column: int) -> list[Any]:
    """The panels of the piston position, from left to right."""
    row = [name for name, _, _ in PANELS].index("piston_position")
    return list(figure.axes[row * n_column : (row + 1) * n_column])


def draw_reference(axis: Any, time: NDArray[np.float64], reference: NDArray[np.float64], color: str) -> None:
    """The reference position of the controller; nothing in open loop."""
    if np.isfinite(reference).any():
        axis.plot(time, 1e3 * reference, color=color, linewidth=0.7, linestyle="--", label="reference")
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


def panel_labels(panels: Panels, wavelet: Any) -> list[str]:
    """Labels of the axes, d2 of P_1 last."""
    return [*(label for _, label, _ in panels), f"$d_{min(2, wavelet.levels)}$ of $P_1$ [kPa]"]


def panel_lines(panels: Panels, signals: dict[str, Line], wavelet: Any) -> list[Line]:
    """The signals in the units of their panels, and d2 of P_1."""
    lines = [(signals[name][0], convert(1.0, unit) * signals[name][1]) for name, _, unit in panels]
    time, pressure = signals[names.CHAMBER_1_PRESSURE]
    instants, details = detail_coefficients(pressure, wavelet, min(2, wavelet.levels), time)
    return [*lines, (instants, 1e-3 * details)]


def draw_panels(columns: list[list[Line]], titles: list[str], colors: list[str], labels: list[str]) -> Figure:
    """Lines below each other, one column for each run."""
    width = 3.6 * len(columns) + (0.0 if len(columns) > 1 else 3.4)
    figure = Figure(figsize=(width, 2.0 + len(labels)), layout="constrained")
    axes = figure.subplots(len(labels), len(columns), sharex=True, sharey="row", squeeze=False)
    for column, (lines, title, color) in enumerate(zip(columns, titles, colors, strict=False)):
        for axis, (x, y), label in zip(axes[:, column], lines, labels, strict=True):
            axis.plot(x, y, color=color, linewidth=0.7)
            axis.set_ylabel(label if column == 0 else "")
        axes[0, column].set_title(title)
        axes[-1, column].xaxis.set_major_locator(MaxNLocator(10, steps=[1, 2, 5, 10]))
        axes[-1, column].set_xlabel("time [s]")
        axes[-1, column].set_xlim(lines[0][0][0], lines[0][0][-1])
    figure.align_ylabels(axes[:, 0])
    return figure
