"""Figures, drawn with matplotlib and no global state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hydrofdi.errors import StoreError
from hydrofdi.features.wavelet import detail_coefficients
from hydrofdi.report.formats import BASELINES, baseline_title, delta_cells, leakage_label
from hydrofdi.report.table import SensitivityTable
from hydrofdi.store import Columns, names
from hydrofdi.units import convert

_BLUE, _ORANGE, _GREY = "#0072B2", "#D55E00", "#595959"
"""Colours that differ for the colour-blind and in grey (after Okabe and Ito)."""


def draw_signals(columns: Columns, wavelet: Any, title: str) -> Figure:
    """Input, stroke, pressures, leakage flow and d2 of P_1 of a run over time.

    Parameters
    ----------
    columns : mapping
        Variables of one run, all signals included.
    wavelet : WaveletConfig
    title : str
    """
    time = columns[names.TIME]
    signal = {name: columns[name][0] for name in columns if name != names.TIME}
    level = min(2, wavelet.levels)
    instants, details = detail_coefficients(signal[names.CHAMBER_1_PRESSURE], wavelet, level, time)
    panels: list[tuple[str, list[tuple[NDArray[np.float64], NDArray[np.float64], str, str]]]] = [
        ("$u$ [V]", [(time, signal[names.INPUT_VOLTAGE], _BLUE, "")]),
        ("$x_p$ [mm]", [(time, 1e3 * signal["piston_position"], _BLUE, "")]),
        (
            "$P$ [MPa]",
            [
                (time, 1e-6 * signal[names.CHAMBER_1_PRESSURE], _BLUE, "$P_1$"),
                (time, 1e-6 * signal[names.CHAMBER_2_PRESSURE], _ORANGE, "$P_2$"),
            ],
        ),
        ("$q_{il}$ [L/min]", [(time, convert(1.0, "L/min") * signal["internal_leakage_flow"], _BLUE, "")]),
        (f"$d_{level}$ of $P_1$ [kPa]", [(instants, 1e-3 * details, _BLUE, "")]),
    ]
    figure = Figure(figsize=(7.0, 8.0), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True)
    for axis, (label, lines) in zip(axes, panels, strict=True):
        for x, y, color, name in lines:
            axis.plot(x, y, color=color, linewidth=0.8, label=name or None)
        axis.set_ylabel(label)
        axis.grid(color="#dddddd", linewidth=0.5)
        if len(lines) > 1:
            axis.legend(loc="upper right", fontsize="small", ncols=len(lines))
    axes[0].set_title(title, loc="left", fontsize="medium")
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(time[0], time[-1])
    figure.align_ylabels(axes)
    return figure


def draw_sensitivity(table: SensitivityTable) -> Figure:
    """δ of all levels over leakage and EBM against both baselines, as a heat map."""
    n_row = len(table.rows)
    figure = Figure(figsize=(9.5, 1.6 + 0.34 * n_row), layout="constrained")
    axes = figure.subplots(1, len(BASELINES), sharey=True)
    for axis, (baseline, delta) in zip(axes, BASELINES.items(), strict=True):
        values = np.array([delta(row) for row in table.rows])
        image = axis.imshow(values, cmap="PuOr_r", vmin=-60.0, vmax=60.0, aspect="auto")
        for y, row in enumerate(table.rows):
            cells = delta_cells(delta(row), "[{}]".format)
            for x, cell in enumerate(cells):
                strong = abs(values[y, x]) > 40.0
                axis.text(
                    x, y, cell.strip("[]"), ha="center", va="center", fontsize=8,
                    color="white" if strong else "black",
                    weight="bold" if cell.startswith("[") else "normal",
                )  # fmt: skip
        _mark_sealed_rows(axis, table)
        axis.set_xticks(range(table.n_level), [f"$d_{level}$" for level in range(1, table.n_level + 1)])
        axis.xaxis.tick_top()
        kind, _, against = baseline_title(table, baseline).partition(" against ")
        axis.set_title(f"{kind} against\n{against}", fontsize="medium")
        axis.tick_params(length=0)
    labels = [_row_label(row) for row in table.rows]
    axes[0].set_yticks(range(n_row), labels, fontsize=8)
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.7)
    bar.set_label("δ [%]  (bold: largest positive of the row)")
    return figure


def _row_label(row: Any) -> str:
    leakage = leakage_label(row)
    unit = "" if row.is_sealed else " L/min"
    return f"{leakage}{unit}, {convert(row.bulk_modulus, 'MPa'):g} MPa"


def _mark_sealed_rows(axis: Any, table: SensitivityTable) -> None:
    n_sealed = sum(row.is_sealed for row in table.rows)
    if 0 < n_sealed < len(table.rows):
        axis.axhline(n_sealed - 0.5, color=_GREY, linewidth=2.0)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; its kind follows from the suffix (.png, .svg, .pdf).

    The bytes depend on the data alone: no clock, no random ids.

    Raises
    ------
    StoreError
        The suffix is unknown, or the file cannot be written.
    """
    import matplotlib

    kinds = figure.canvas.get_supported_filetypes()
    kind = path.suffix.lstrip(".").lower()
    if kind not in kinds:
        raise StoreError(f"{path}: figures are written as .png, .svg or .pdf")
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with matplotlib.rc_context({"svg.hashsalt": "hydrofdi", "svg.fonttype": "path"}):
            figure.savefig(path, dpi=150, metadata=metadata.get(kind))
    except OSError as error:
        raise StoreError(f"{path}: cannot be written: {error.strerror}") from None
