"""A report: sections of paragraphs and tables, and figures, from which every form follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from hydrofdi.report.table import Table


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


def group_breaks(keys: Sequence[object]) -> tuple[int, ...]:
    """Positions at which a key differs from the one before."""
    return tuple(position for position in range(1, len(keys)) if keys[position] != keys[position - 1])


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
