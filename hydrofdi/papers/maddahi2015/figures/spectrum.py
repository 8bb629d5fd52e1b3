"""Power spectrum of P_1 with the bands of the levels and the hydraulic mode of each EBM."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.figures.choice import run_position, shown_bulk_moduli
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.style import INK, series
from hydrofdi.report.figures.ticks import log_axis
from hydrofdi.report.runs import ROUNDING
from hydrofdi.report.wording import mode_name, modulus_text
from hydrofdi.store.layout import names
from hydrofdi.transforms.spectrum import power_spectrum


def draw_spectrum(study: Study) -> Figure:
    """Spectra of P_1, sealed and with the largest leakage, one line per EBM; none if it is still."""
    grid = study.grid
    leakages = list(dict.fromkeys((0, len(grid.leakage_flows))))
    figure = Figure(figsize=(8.0, 0.8 + 2.6 * len(leakages)), layout="constrained")
    axes = figure.subplots(len(leakages), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    has_spectrum = [_draw_leakage(axis, study, leakage) for axis, leakage in zip(axes, leakages, strict=True)]
    if not any(has_spectrum):
        raise ReportError("P_1 does not vary, so it has no spectrum")
    for axis in axes:
        log_axis(axis.xaxis)
        log_axis(axis.yaxis)
    lines, _ = axes[has_spectrum.index(True)].get_legend_handles_labels()
    mode = Line2D([], [], color=INK, linewidth=1.2, linestyle=":", label="its mode $f_h$")
    figure.legend(handles=[*lines, mode], loc="outside right upper", title="EBM")
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def _draw_leakage(axis: Any, study: Study, leakage: int) -> bool:
    """Draw the spectra of one leakage; whether there is any."""
    grid, data = study.grid, study.data
    sampling_frequency = data.experiment.record.sampling_frequency
    has_spectrum = False
    moduli = shown_bulk_moduli(study)
    for number, beta in enumerate(moduli):
        style = series(number, len(moduli))
        position = run_position(study, leakage, beta)
        _, pressure = data.signal(names.CHAMBER_1_PRESSURE, position)
        frequency, density = power_spectrum(pressure, sampling_frequency)
        name = modulus_text(grid.bulk_moduli[beta])
        stands_still = np.ptp(pressure) <= ROUNDING * np.abs(pressure).max()
        if not stands_still:
            axis.plot(frequency[1:], 1e-6 * density[1:], label=name, **style)
            has_spectrum = True
        mode = float(data.columns[names.MODE_FREQUENCY][position])
        axis.axvline(mode, color=style["color"], linewidth=1.2, linestyle=":")
    _mark_bands(axis, study)
    flow = grid.leakage_flows[leakage - 1] if leakage else 0.0
    axis.set_title(mode_name(flow, 0.0).partition(" at ")[0])
    axis.set_ylabel("PSD of $P_1$ [kPa²/Hz]")
    return has_spectrum


def _mark_bands(axis: Any, study: Study) -> None:
    bands = study.table.bands
    axis.set_xlim(bands[-1][0] / 2, bands[0][1])
    axis.grid(visible=False, axis="x", which="both")
    for level, (low, high) in enumerate(bands, 1):
        if level % 2:
            axis.axvspan(low, high, color="#808088", alpha=0.14, linewidth=0)
        axis.text(
            (low * high) ** 0.5, 0.97, f"$d_{level}$", transform=axis.get_xaxis_transform(),
            ha="center", va="top", color=INK,
        )  # fmt: skip
