"""Figures 2 to 4, spectra, and the plane of the hydraulic mode: what runs of a scenario look like."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.figures.conclusions import draw_phases, draw_scenarios
from hydrofdi.papers.maddahi2015.grid import ABSENT
from hydrofdi.report.figures.signals import PANELS, draw_beside
from hydrofdi.report.figures.style import INK, MARKERS, RULE, log_axis, mark_bands, series, time_axis
from hydrofdi.report.runs import ROUNDING
from hydrofdi.report.table import FigureKind
from hydrofdi.report.wording import kilopascal, litres_per_minute, mode_name, modulus_text, shown_modulus
from hydrofdi.store.layout import names
from hydrofdi.transforms.spectrum import power_spectrum
from hydrofdi.transforms.wavelet import detail_coefficients

if TYPE_CHECKING:
    from hydrofdi.papers.maddahi2015.data import StudyData

_NAMED = 14
"""EBM that have room side by side."""


def _position(study: StudyData, leakage: int, bulk_modulus: int) -> int:
    """Row of a run of the first scenario; `leakage` 0 is the sealed actuator, 1 the smallest leakage."""
    position = int(study.grid.positions[0, leakage, bulk_modulus])
    if position == ABSENT:
        raise ReportError("the experiment has no run of this leakage and EBM")
    status = study.data.columns[names.STATUS][position]
    if status != "ok":
        raise ReportError(f"a run of the figure has no results: {status}")
    return position


def _flow(study: StudyData, leakage: int) -> float:
    return study.grid.leakage_flows[leakage - 1] if leakage else 0.0


def _small_leak(study: StudyData) -> tuple[int, list[int]]:
    """The smallest leakage, or the sealed actuator if there is none; positions of the EBM with such a run."""
    leakage = min(1, len(study.grid.leakage_flows))
    return leakage, np.flatnonzero(study.grid.positions[0, leakage] != ABSENT).tolist()


def _stacked(n_panel: int, width: float, lead: float, height: float) -> tuple[Figure, Any]:
    """Panels below each other with common axes."""
    figure = Figure(figsize=(width, lead + height * n_panel), layout="constrained")
    return figure, figure.subplots(n_panel, 1, sharex=True, sharey=True, squeeze=False)[:, 0]


def draw_figure_2(study: StudyData) -> Figure:
    """Figure 2: (a) normal and (b) with the small leakage, both at the normal EBM."""
    grid, data = study.grid, study.data
    leakages = list(dict.fromkeys((0, _small_leak(study)[0])))
    runs = [_position(study, leakage, grid.normal) for leakage in leakages]
    columns: dict[str, Any] = {name: [data.signal(name, run)[1] for run in runs] for name, _, _ in PANELS}
    columns[names.TIME] = data.signal(names.CHAMBER_1_PRESSURE, runs[0])[0]
    columns[names.REFERENCE_POSITION] = [
        np.array([np.nan])
        if data.values("control.law")[run] == "open"
        else data.signal(names.REFERENCE_POSITION, run)[1]
        for run in runs
    ]
    modes = (mode_name(_flow(study, leakage), grid.bulk_moduli[grid.normal]) for leakage in leakages)
    titles = [f"({letter}) {mode}" for letter, mode in zip("ab", modes, strict=False)]
    return draw_beside(columns, titles, data.experiment.wavelet)


def draw_details(study: StudyData, level: int) -> Figure:
    """Figures 3 and 4: the coefficients of a level of P_1 with the small leakage, one panel per EBM."""
    wavelet, (leakage, moduli) = study.data.experiment.wavelet, _small_leak(study)
    if level > wavelet.levels:
        raise ReportError(f"the experiment has no level d{level}")
    figure, axes = _stacked(len(moduli), 7.0, 0.6, 1.6)
    for number, (axis, beta) in enumerate(zip(axes, moduli, strict=True)):
        position = _position(study, leakage, beta)
        time, pressure = study.data.signal(names.CHAMBER_1_PRESSURE, position)
        instants, details = detail_coefficients(pressure, wavelet, level, time)
        axis.plot(instants, 1e-3 * details, color=series(number, len(moduli))["color"], linewidth=0.7)
        rms = float(study.data.columns[names.DETAIL_RMS][position][level - 1])
        mode = mode_name(_flow(study, leakage), study.grid.bulk_moduli[beta])
        axis.set(title=f"{mode}: RMS {kilopascal(rms)} kPa", ylabel=f"$d_{level}$ of $P_1$ [kPa]")
    time_axis(axes[-1], time)
    return figure


def draw_spectrum(study: StudyData) -> Figure:
    """Spectra of P_1, sealed and with the largest leakage, one line per EBM; none if it is still."""
    leakages = list(dict.fromkeys((0, len(study.grid.leakage_flows))))
    figure, axes = _stacked(len(leakages), 8.0, 0.8, 2.6)
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


def _draw_leakage(axis: Any, study: StudyData, leakage: int) -> bool:
    """Draw the spectra of one leakage, and the bands; whether there is any spectrum."""
    data, (_, moduli), has_spectrum = study.data, _small_leak(study), False
    for number, beta in enumerate(moduli):
        style = series(number, len(moduli))
        position = _position(study, leakage, beta)
        _, pressure = data.signal(names.CHAMBER_1_PRESSURE, position)
        frequency, density = power_spectrum(pressure, data.experiment.record.sampling_frequency)
        if np.ptp(pressure) > ROUNDING * np.abs(pressure).max():
            name = modulus_text(study.grid.bulk_moduli[beta])
            axis.plot(frequency[1:], 1e-6 * density[1:], label=name, **style)
            has_spectrum = True
        mode = float(data.columns[names.MODE_FREQUENCY][position])
        axis.axvline(mode, color=style["color"], linewidth=1.2, linestyle=":")
    bands = study.table.bands
    axis.grid(visible=False, axis="x", which="both")
    mark_bands(axis, bands)
    axis.set(
        xlim=(bands[-1][0] / 2, bands[0][1]),
        title=mode_name(_flow(study, leakage), 0.0).partition(" at ")[0],
        ylabel="PSD of $P_1$ [kPa²/Hz]",
    )
    return has_spectrum


def draw_mode_plane(study: StudyData) -> Figure:
    """The hydraulic mode of every run, linearised at its median working point."""
    grid, columns = study.grid, study.data.columns
    positions = grid.positions[0]
    frequency, damping = (
        np.where(positions == ABSENT, np.nan, columns[name][positions])
        for name in (names.MODE_FREQUENCY, names.MODE_DAMPING_RATIO)
    )
    if np.isnan(frequency).all():
        raise ReportError("no run succeeded")
    figure = Figure(figsize=(7.4, 4.2), layout="constrained")
    axis = figure.subplots()
    axis.plot(frequency, damping, color=RULE, linewidth=1.2, zorder=1)
    for row in range(len(positions)):
        style, flow = series(row, len(positions)), _flow(study, row)
        axis.plot(
            frequency[row], damping[row], **style, linewidth=0.9, marker=MARKERS[row % len(MARKERS)],
            markerfacecolor=style["color"] if row else "none",
            label=f"{litres_per_minute(flow)} L/min" if flow else "sealed",
        )  # fmt: skip
    _name_bulk_moduli(axis, study, frequency, damping)
    low, high = np.nanmin(frequency), np.nanmax(frequency)
    for level, (_, border) in enumerate(study.table.bands, 1):
        if low * 0.9 < border < high * 1.1 and level > 1:
            axis.axvline(border, color=INK, linewidth=0.8, linestyle=":")
            axis.text(
                border, 1.01, f" $d_{level}$ | $d_{level - 1}$ ", transform=axis.get_xaxis_transform(),
                ha="center", va="bottom", color=INK,
            )  # fmt: skip
    axis.set(xlabel="frequency of the hydraulic mode $f_h$ [Hz]", ylabel="hydraulic damping ζ [–]")
    title = f"leakage; numbers: EBM [{shown_modulus().unit}]"
    axis.legend(title=title, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _name_bulk_moduli(axis: Any, study: StudyData, frequency: Any, damping: Any) -> None:
    apart, last = np.ptp(frequency[np.isfinite(frequency)]) / _NAMED, -np.inf
    for column, beta in enumerate(study.grid.bulk_moduli):
        known = ~np.isnan(damping[:, column])
        if known.any() and frequency[known, column][0] >= last + apart:
            last = frequency[known, column][0]
            at = (last, damping[known, column].max())
            text = shown_modulus().text(beta)
            axis.annotate(text, at, (0, 8), textcoords="offset points", ha="center", fontsize=8)
    axis.margins(0.12, 0.15)


def study_figures(study: StudyData) -> dict[str, FigureKind]:
    """Name → figure."""
    figures: dict[str, tuple[str, Callable[..., Any]]] = {
        "figure2": ("Figure 2: signals and d2 of P_1, normal and with the small leakage", draw_figure_2),
        "figure3": ("Figure 3: d2 of P_1 over the EBM, small leakage", partial(draw_details, level=2)),
        "figure4": ("Figure 4: d3 of P_1 over the EBM, small leakage", partial(draw_details, level=3)),
        "spectrum": (
            "Spectrum of P_1 with the bands of the levels and the hydraulic mode",
            draw_spectrum,
        ),
        "mode_plane": ("The hydraulic mode: EBM moves its frequency, leakage its damping", draw_mode_plane),
        "phases": (
            "Claims and the sealed alarm at every start phase, and settled",
            draw_phases,
        ),
        "scenarios": ("Scenarios that reproduce the claims, and the values that carry it", draw_scenarios),
    }
    return {name: FigureKind(caption, partial(draw, study)) for name, (caption, draw) in figures.items()}
