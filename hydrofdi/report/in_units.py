"""A report in the units of its experiment file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hydrofdi.config.shown_values import shown_in
from hydrofdi.report.contract import ComposedReport, FigureKind
from hydrofdi.report.document import Document


@dataclass(frozen=True)
class ReportInUnits:
    """A report whose sections and figures show parameters in given units; data for programs are unchanged.

    Attributes
    ----------
    report : ComposedReport
    units : dict
        Dotted parameter → unit.
    """

    report: ComposedReport
    units: Mapping[str, str]

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.report.name

    @property
    def path(self) -> Path:
        """The file that it was made from."""
        return self.report.path

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        return self.report.usual_figure

    def document(self) -> Document:
        """The sections of the report."""
        with shown_in(self.units):
            return self.report.document()

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return self.report.record()

    def columns(self) -> dict[str, list[Any]]:
        """Header with unit → values."""
        return self.report.columns()

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        with shown_in(self.units):
            return {name: self._shown(kind) for name, kind in self.report.figures().items()}

    def checks(self) -> dict[str, bool | None]:
        """Sentence on each check → whether it holds; None if undecided."""
        return self.report.checks()

    def _shown(self, kind: FigureKind) -> FigureKind:
        def draw() -> Any:
            with shown_in(self.units):
                return kind.draw()

        return replace(kind, draw=draw)
