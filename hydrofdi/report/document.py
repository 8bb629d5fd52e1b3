"""A report as sections of paragraphs and tables, free of any form.

Every form (terminal, Markdown, LaTeX, the page) renders these same texts, so that none says anything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A cell of a sheet.

    Attributes
    ----------
    text : str
    is_strong : bool
        Whether it stands out in its row.
    value : float, str or None
        What the text was made from, for programs.
    """

    text: str
    is_strong: bool = False
    value: float | str | None = None


@dataclass(frozen=True)
class Sheet:
    """A table.

    Attributes
    ----------
    key : str
        Identity within the report.
    title : str
    headers : tuple of str
    rows : tuple of tuple of Cell
        Each as long as `headers`.
    breaks : tuple of int
        Rows before which a gap or a line separates groups.
    text_columns : tuple of int
        Columns of words; the others hold numbers.
    note : str
        Legend below the table.
    """

    key: str
    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    breaks: tuple[int, ...] = ()
    text_columns: tuple[int, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class Block:
    """A section of a report: a heading, what the numbers say, tables, and names of figures."""

    key: str
    title: str
    paragraphs: tuple[str, ...] = ()
    sheets: tuple[Sheet, ...] = ()
    figures: tuple[str, ...] = ()


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
