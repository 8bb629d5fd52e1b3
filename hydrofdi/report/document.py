"""A report before it is written in any form: sections of tables and figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hydrofdi.tables.table import Table


@dataclass(frozen=True)
class Block:
    """A section of a report: a heading, what the numbers say, tables, and names of figures.

    Answers are what a terminal shows of a report, and shows last.
    """

    key: str
    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[str, ...] = ()
    is_answer: bool = False

    @property
    def shown_tables(self) -> tuple[Table, ...]:
        """The tables that have rows."""
        return tuple(table for table in self.tables if len(table))


@dataclass(frozen=True)
class Document:
    """A report."""

    title: str
    lead: tuple[str, ...]
    blocks: tuple[Block, ...]

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of all figures."""
        return tuple(name for block in self.blocks for name in block.figures)


@dataclass(frozen=True)
class FigureKind:
    """A figure of a report: its caption, and what draws it with matplotlib."""

    caption: str
    draw: Callable[[], Any]


class ComposedReport(Protocol):
    """A report before it is written in any form, whatever it is about."""

    @property
    def name(self) -> str:
        """The experiment."""

    @property
    def path(self) -> Path:
        """The experiment file."""

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""

    def document(self) -> Document:
        """Its sections."""

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""

    def columns(self) -> dict[str, list[Any]]:
        """Header → values of CSV."""

    def wide(self) -> dict[str, list[Any]]:
        """Header → values, one per run."""

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""

    def checks(self) -> dict[str, bool | None]:
        """Claim that the experiment lists → whether it holds."""
