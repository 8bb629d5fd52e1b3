"""What a report is to those that print, draw and publish it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hydrofdi.report.document import Document


@dataclass(frozen=True)
class FigureKind:
    """A figure of a report: its caption, and what draws it with matplotlib."""

    caption: str
    draw: Callable[[], Any]


class ComposedReport(Protocol):
    """The report of an experiment: general, of a study of detection, or of a paper's study."""

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        ...

    @property
    def path(self) -> Path:
        """The file that it was made from."""
        ...

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        ...

    def document(self) -> Document:
        """The sections of the report."""
        ...

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        ...

    def columns(self) -> dict[str, list[Any]]:
        """Header with unit → values, for CSV and Parquet; None if a number is missing."""
        ...

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        ...

    def checks(self) -> dict[str, bool | None]:
        """Sentence on each check that the experiment file asks for → whether it holds; None: not decided."""
        ...
