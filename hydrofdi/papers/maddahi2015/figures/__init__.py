"""The figures of the paper's study."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from hydrofdi.papers.maddahi2015.figures.conclusions import draw_phases, draw_scenarios
from hydrofdi.papers.maddahi2015.figures.signals import (
    draw_details,
    draw_figure_2,
    draw_mode_plane,
    draw_spectrum,
)
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import FigureKind


def study_figures(study: Study) -> dict[str, FigureKind]:
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
