"""A report as sections of paragraphs and tables, from which every form follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
