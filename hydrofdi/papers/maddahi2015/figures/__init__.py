"""The figures of the paper's study; one module per figure."""

from __future__ import annotations

from functools import partial

from hydrofdi.papers.maddahi2015.figures.details import draw_details
from hydrofdi.papers.maddahi2015.figures.figure_2 import draw_figure_2
from hydrofdi.papers.maddahi2015.figures.mode_plane import draw_mode_plane
from hydrofdi.papers.maddahi2015.figures.phases import draw_phases
from hydrofdi.papers.maddahi2015.figures.scenarios import draw_scenarios
from hydrofdi.papers.maddahi2015.figures.spectrum import draw_spectrum
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.contract import FigureKind
from hydrofdi.report.figures.sensitivity import draw_sensitivity


def study_figures(study: Study) -> dict[str, FigureKind]:
    """Name → figure."""
    return {
        "figure2": FigureKind(
            "Figure 2: signals and d2 of the chamber-1 pressure, normal and with the small leakage",
            partial(draw_figure_2, study),
        ),
        "figure3": FigureKind(
            "Figure 3: d2 of the chamber-1 pressure over the EBM, small leakage",
            partial(draw_details, study, 2),
        ),
        "figure4": FigureKind(
            "Figure 4: d3 of the chamber-1 pressure over the EBM, small leakage",
            partial(draw_details, study, 3),
        ),
        "sensitivity": FigureKind(
            "δ over leakage, EBM and level against the fixed and the matched baseline; sealed controls on"
            " top",
            partial(draw_sensitivity, study),
        ),
        "spectrum": FigureKind(
            "Power spectrum of the chamber-1 pressure with the bands of the levels and the hydraulic mode",
            partial(draw_spectrum, study),
        ),
        "mode_plane": FigureKind(
            "The hydraulic mode: EBM moves its frequency, leakage moves its damping",
            partial(draw_mode_plane, study),
        ),
        "phases": FigureKind(
            "Claims and the sealed alarm at every start phase: the configured one and the settled record"
            " marked",
            partial(draw_phases, study),
        ),
        "scenarios": FigureKind(
            "Scenarios that reproduce the claims, and the parameter values that carry it",
            partial(draw_scenarios, study),
        ),
    }
