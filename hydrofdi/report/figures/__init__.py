"""Figures, drawn with matplotlib and no global state; one module per figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from hydrofdi.errors import HydrofdiError, StoreError
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.figures.details import draw_figure_3, draw_figure_4
from hydrofdi.report.figures.mode_plane import draw_mode_plane
from hydrofdi.report.figures.phases import draw_phases
from hydrofdi.report.figures.readings import draw_readings
from hydrofdi.report.figures.sensitivity import draw_sensitivity
from hydrofdi.report.figures.signals import draw_figure_2, draw_signals
from hydrofdi.report.figures.spectrum import draw_spectrum
from hydrofdi.report.figures.style import SETTINGS, figure_bytes
from hydrofdi.store.files import whole_file

__all__ = [
    "FIGURES",
    "KINDS",
    "Figure",
    "FigureKind",
    "draw_all",
    "draw_figure",
    "draw_signals",
    "save_figure",
    "write_figure",
]

KINDS = ("png", "svg", "pdf")
"""File types of figures."""


@dataclass(frozen=True)
class FigureKind:
    """A figure of the report: its caption, and what draws it."""

    caption: str
    draw: Callable[[Analysis], Figure]


FIGURES = {
    "figure2": FigureKind(
        "Figure 2: signals and d2 of the chamber-1 pressure, normal and with the small leakage", draw_figure_2
    ),
    "figure3": FigureKind(
        "Figure 3: d2 of the chamber-1 pressure over the EBM, small leakage", draw_figure_3
    ),
    "figure4": FigureKind(
        "Figure 4: d3 of the chamber-1 pressure over the EBM, small leakage", draw_figure_4
    ),
    "sensitivity": FigureKind(
        "δ over leakage, EBM and level against the fixed and the matched baseline; sealed controls on top",
        draw_sensitivity,
    ),
    "spectrum": FigureKind(
        "Power spectrum of the chamber-1 pressure with the bands of the levels and the hydraulic mode",
        draw_spectrum,
    ),
    "mode_plane": FigureKind(
        "The hydraulic mode: EBM moves its frequency, leakage moves its damping", draw_mode_plane
    ),
    "phases": FigureKind(
        "Claims and the sealed alarm at every start phase: the configured one and the settled record marked",
        draw_phases,
    ),
    "readings": FigureKind(
        "Readings that reproduce the claims, and the parameter values that carry it", draw_readings
    ),
}
"""Name → figure."""


def draw_figure(analysis: Analysis, name: str) -> Figure:
    """A figure of the report.

    Raises
    ------
    HydrofdiError
        The experiment does not hold what the figure shows; the message says why.
    """
    with matplotlib.rc_context(SETTINGS):
        return FIGURES[name].draw(analysis)


def draw_all(analysis: Analysis, names: Sequence[str]) -> tuple[dict[str, Figure], dict[str, str]]:
    """The figures of these names that the experiment allows, and for the others the reason why not."""
    drawn: dict[str, Figure] = {}
    holes: dict[str, str] = {}
    for name in names:
        try:
            drawn[name] = draw_figure(analysis, name)
        except HydrofdiError as error:
            holes[name] = str(error)
    return drawn, holes


def write_figure(analysis: Analysis, path: Path) -> str:
    """Draw the figure that a file is named after, else δ or the readings; returns its caption.

    Raises
    ------
    HydrofdiError
        It cannot be drawn or written.
    """
    usual = "sensitivity" if analysis.readings is None else "readings"
    name = path.stem if path.stem in FIGURES else usual
    save_figure(draw_figure(analysis, name), path)
    return FIGURES[name].caption


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; its kind follows from the suffix (.png, .svg, .pdf).

    Raises
    ------
    StoreError
        The suffix is unknown, or the file cannot be written.
    """
    kind = path.suffix.lstrip(".").lower()
    if kind not in KINDS:
        raise StoreError(f"{path}: figures are written as .png, .svg or .pdf")
    content = figure_bytes(figure, kind)
    with whole_file(path) as aside:
        aside.write_bytes(content)
