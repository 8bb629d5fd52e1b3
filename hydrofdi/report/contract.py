"""What a report is to those that print, draw and publish it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Document


@dataclass(frozen=True)
class FigureKind:
    """A figure of a report: its caption, and what draws it with matplotlib."""

    caption: str
    draw: Callable[[], Any]


class ComposedReport(Protocol):
    """The report of an experiment, general or of a paper's study."""

    @property
    def analysis(self) -> Analysis:
        """What it is of."""
        ...

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn where none is named."""
        ...

    def document(self) -> Document:
        """Its sections."""
        ...

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        ...

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        ...
