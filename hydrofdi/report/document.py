"""A report as sections of paragraphs and tables, free of any form.

Every form (terminal, Markdown, the page) renders these same texts, so that none says anything else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, overload

Source = TypeVar("Source")


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
    mark : str
        What follows a cell that stands out if there is no bold type.
    """

    text: str
    is_strong: bool = False
    value: float | str | None = None
    mark: str = "*"


class Rows(Sequence[tuple[Cell, ...]]):
    """Rows of a sheet that are made when they are asked for: a terminal shows a few of many thousands.

    Parameters
    ----------
    sources : sequence
        What the rows are made from.
    make : callable
        Source → row.
    """

    def __init__(self, sources: Sequence[Source], make: Callable[[Source], tuple[Cell, ...]]) -> None:
        self._sources: Sequence[Any] = sources
        self._make: Callable[[Any], tuple[Cell, ...]] = make

    def __len__(self) -> int:
        return len(self._sources)

    @overload
    def __getitem__(self, key: int) -> tuple[Cell, ...]: ...
    @overload
    def __getitem__(self, key: slice) -> Rows: ...
    def __getitem__(self, key: int | slice) -> tuple[Cell, ...] | Rows:
        if isinstance(key, slice):
            return Rows(self._sources[key], self._make)
        return self._make(self._sources[key])


@dataclass(frozen=True)
class Sheet:
    """A table.

    Attributes
    ----------
    key : str
        Identity within the report.
    title : str
    headers : tuple of str
    rows : sequence of tuple of Cell
        Each as long as `headers`.
    breaks : tuple of int
        Rows before which a gap or a line separates groups.
    text_columns : tuple of int
        Columns of words; the others hold numbers.
    note : str
        Legend below the table.
    n_lead : int
        Columns at the left that say what a row is, repeated where the others need several parts.
    digest : Sheet or None
        What forms for people show in its place, such as quantiles of thousands of rows.
    page_rows : int or None
        Rows that the first page of a terminal shows; None: as many as of any other table.
    is_folded : bool
        Whether the page shows it only when it is opened, and the terminal only says how long it is.
    """

    key: str
    title: str
    headers: tuple[str, ...]
    rows: Sequence[tuple[Cell, ...]]
    breaks: tuple[int, ...] = ()
    text_columns: tuple[int, ...] = ()
    note: str = ""
    n_lead: int = 1
    digest: Sheet | None = None
    page_rows: int | None = None
    is_folded: bool = False

    @property
    def shown(self) -> Sheet:
        """Its digest, or itself if it has none."""
        return self.digest or self


@dataclass(frozen=True)
class Block:
    """A section of a report: a heading, what the numbers say, tables, and names of figures.

    A detail is what the first page of a report has no room for.
    """

    key: str
    title: str
    paragraphs: tuple[str, ...] = ()
    sheets: tuple[Sheet, ...] = ()
    figures: tuple[str, ...] = ()
    is_detail: bool = False

    @property
    def shown_sheets(self) -> tuple[Sheet, ...]:
        """The tables, long ones as their digests."""
        return tuple(sheet.shown for sheet in self.sheets)


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
