"""Tables on the terminal: numbers are never cut; columns that do not fit continue below."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text

from hydrofdi.cli.folding import Folded
from hydrofdi.report.table import Column, Table

_GAP, _HEADING, _SENTENCE = 2, 14, 24
"""Blanks between columns, and widths: of a line of a heading, and of folded words."""


def print_table(console: Console, table: Table, n_row: int | None = None) -> None:
    """Print a table with its title and notes, or only its first rows."""
    if table.title:
        console.print(Text(table.title, style="bold"))
    rows = [*table.texts(n_row)]
    for places in _parts(table.shown, rows, table.n_shown_lead, console.width):
        grid = Grid(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
        for place in places:
            column = table.shown[place]
            side, fold = ("left", True) if column.is_text else ("right", False)
            grid.add_column(_lines(column), justify=side, overflow="fold", no_wrap=not fold)  # type: ignore[arg-type]
        for position, row in enumerate(rows):
            if position in table.breaks:
                grid.add_row()
            grid.add_row(*(_cell(table.shown[at], *row[at]) for at in places))
        console.print(grid)
    if len(rows) < len(table):
        console.print(f"… the first {len(rows)} of {len(table):,} rows")
    for note in table.notes:
        console.print(Text(note, style="dim"))


def _cell(column: Column, text: str, is_strong: bool) -> Text | Folded:
    """A text with a mark that also shows without bold type."""
    shown = text + ("*" if is_strong else " " if column.strong and not column.is_text else "")
    return (Folded if column.is_text else Text)(shown, "bold" if is_strong else "")


def _lines(column: Column) -> str:
    """A heading in lines, broken at blanks, dots and underscores; its unit in the last, room for a mark."""
    room = " " if column.strong and not column.is_text else ""
    name, bracket, unit = column.heading.partition(" [")
    lines = [""]
    for piece in re.findall(r"[^._ ]*[._ ]|[^._ ]+", name):
        if lines[-1] and len(lines[-1] + piece.rstrip()) > _HEADING:
            lines.append("")
        lines[-1] += piece
    return "\n".join(f"{line.rstrip()}{room}" for line in [*lines, *([f"[{unit}"] if bracket else [])])


def _parts(
    columns: tuple[Column, ...], rows: list[list[tuple[str, bool]]], n_lead: int, room: int
) -> Iterator[list[int]]:
    """Columns that fit beside each other; each part begins with those that say what a row is."""
    widths = [
        max(len(text) for text in [*_lines(column).split("\n"), *(row[place][0] for row in rows)])
        + bool(column.strong)
        for place, column in enumerate(columns)
    ]
    widths = [min(width, _SENTENCE) if columns[at].is_text else width for at, width in enumerate(widths)]
    lead = [*range(n_lead)]
    part = [*lead]
    for place in range(n_lead, len(columns)):
        if len(part) > n_lead and sum(widths[at] + _GAP for at in [*part, place]) - _GAP > room:
            yield part
            part = [*lead]
        part.append(place)
    yield part
