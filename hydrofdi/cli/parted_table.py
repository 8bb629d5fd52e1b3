"""Tables of numbers that are never cut: columns that do not fit continue below."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table

_GAP = 2


@dataclass
class PartedTable:
    """Columns of short texts and numbers, in as many tables as the width requires.

    Attributes
    ----------
    headers : sequence of str
        Lines of a header are separated by line ends.
    n_lead : int
        Number of first columns, which identify a row; each table begins with them.
    left : collection of int
        Left-aligned columns.
    """

    headers: Sequence[str]
    n_lead: int = 1
    left: Collection[int] = ()
    rows: list[Sequence[str]] = field(default_factory=list)

    def add_row(self, *cells: str) -> None:
        """Add a row, a cell for each header."""
        self.rows.append(cells)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The tables, one below the other."""
        for columns in self._parts(options.max_width):
            part = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
            for column in columns:
                is_left = column in self.left
                part.add_column(self.headers[column], justify="left" if is_left else "right", no_wrap=True)
            for row in self.rows:
                part.add_row(*(row[column] for column in columns))
            yield part

    def _parts(self, room: int) -> list[list[int]]:
        lead = list(range(self.n_lead))
        parts: list[list[int]] = []
        for column in range(self.n_lead, len(self.headers)):
            if parts and self._width([*parts[-1], column]) <= room:
                parts[-1].append(column)
            else:
                parts.append([*lead, column])
        return parts

    def _width(self, columns: Sequence[int]) -> int:
        return sum(self._width_of(column) + _GAP for column in columns) - _GAP

    def _width_of(self, column: int) -> int:
        texts = [*self.headers[column].split("\n"), *(row[column] for row in self.rows)]
        return max(map(cell_len, texts))
