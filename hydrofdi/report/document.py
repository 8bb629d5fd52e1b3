"""A report as sections of paragraphs and tables, from which every form follows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, overload

from hydrofdi.report.table import Column, Table

Source = TypeVar("Source")


@dataclass(frozen=True)
class Cell:
    """A cell of a `Sheet`."""

    text: str
    is_strong: bool = False
    value: float | str | None = None
    mark: str = "*"


class Rows(Sequence[tuple[Cell, ...]]):
    """Rows of a `Sheet`, each made from a source."""

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
    """A table by its cells: only until all sections have a `Table`."""

    key: str
    title: str
    headers: tuple[str, ...]
    rows: Sequence[tuple[Cell, ...]]
    breaks: tuple[int, ...] = ()
    text_columns: tuple[int, ...] = ()
    note: str = ""
    n_lead: int = 1
    is_folded: bool = False

    def as_table(self) -> Table:
        """The same by its columns."""
        rows = list(self.rows)
        columns = [
            Column(
                header,
                [row[place].text + (row[place].mark if row[place].mark != "*" else "") * row[place].is_strong
                 for row in rows],
                is_text=place in self.text_columns,
                strong=tuple(k for k, row in enumerate(rows) if row[place].is_strong),
            )
            for place, header in enumerate(self.headers)
        ]  # fmt: skip
        notes = (self.note,) if self.note else ()
        return Table(
            tuple(columns), self.title, self.key, notes, self.breaks, self.n_lead, "row", self.is_folded
        )


@dataclass(frozen=True)
class Block:
    """A section of a report: a heading, what the numbers say, tables, and names of figures.

    Answers are what a terminal shows of a report, and shows last.
    """

    key: str
    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table | Sheet, ...] = ()
    figures: tuple[str, ...] = ()
    is_answer: bool = False

    @property
    def shown_tables(self) -> tuple[Table, ...]:
        """The tables that have rows."""
        made = (each.as_table() if isinstance(each, Sheet) else each for each in self.tables)
        return tuple(table for table in made if len(table))


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
