"""Figures, drawn with matplotlib and no global state; one module per figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure

from hydrofdi.errors import HydrofdiError, ReportError, StoreError
from hydrofdi.report.figures.style import SETTINGS, figure_bytes, shown
from hydrofdi.settings.messages import similar
from hydrofdi.store.files import whole_file

if TYPE_CHECKING:
    from hydrofdi.report.document import ComposedReport

KINDS = ("png", "svg", "pdf")
"""File types of figures."""


def draw_figure(report: ComposedReport, name: str) -> Figure:
    """A figure of a report."""
    figures = report.figures()
    if not figures:
        raise ReportError(
            "there is nothing to draw: no run has results; 'hydrofdi sweep CONFIG' computes the missing runs"
        )
    if name not in figures:
        raise ReportError(f"no figure {name!r}; there are {', '.join(figures)}{similar(name, [*figures])}")
    with matplotlib.rc_context(SETTINGS):
        return shown(figures[name].draw())


def draw_all(report: ComposedReport, names: Sequence[str]) -> tuple[dict[str, Figure], dict[str, str]]:
    """The figures of these names that the experiment allows, and the reasons why others are missing."""
    drawn: dict[str, Figure] = {}
    holes: dict[str, str] = {}
    for name in names:
        try:
            drawn[name] = draw_figure(report, name)
        except HydrofdiError as error:
            holes[name] = str(error)
    return drawn, holes


def write_figure(report: ComposedReport, path: Path, name: str = "") -> str:
    """Draw a figure by its name, or that which a file is named after; returns its caption."""
    save_figure(draw_figure(report, name or path.stem), path)
    return report.figures()[name or path.stem].caption


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure; its kind follows from the suffix (.png, .svg, .pdf)."""
    kind = path.suffix.lstrip(".").lower()
    if kind not in KINDS:
        raise StoreError(f"{path}: figures are written as .png, .svg or .pdf")
    content = figure_bytes(figure, kind)
    with whole_file(path) as aside:
        aside.write_bytes(content)
