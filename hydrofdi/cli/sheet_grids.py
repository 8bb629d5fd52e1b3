"""Tables of a report on the terminal, in as many columns as fit."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.folding import Folded
from hydrofdi.report.document import Cell, Sheet

_ANY_WIDTH, _SENTENCE_WIDTH = 10_000, 30
_UNIT, _WORD, _DOT, _UNDERSCORE = r" (?=\[)", " ", r"(?<=[^\W\d]\.)", r"(?<=\w_)(?=\w\w)"
_HEADER_FORMS = (
    (r"(?!)", 2),
    (_UNIT, 2),
    (f"{_WORD}|{_DOT}", 2),
    (f"{_WORD}|{_DOT}|{_UNDERSCORE}", 2),
    (f"{_WORD}|{_DOT}|{_UNDERSCORE}", 1),
)
"""Where headings are broken, and the gap between columns; the narrowest last."""


def sheet_grids(sheet: Sheet, console: Console) -> Iterator[Table]:
    """A table, in several parts with the same first columns if the terminal is too narrow for all.

    Numbers are broken only if the first columns and a single further column are too wide.
    """
    rest = list(range(sheet.n_lead, len(sheet.headers)))
    lead = list(range(sheet.n_lead))
    while rest:
        count = len(rest)
        while count > 1 and not _fits(_columns(sheet, lead + rest[:count]), console):
            count -= 1
        yield _fitting_grid(_columns(sheet, lead + rest[:count]), console)
        rest = rest[count:]


def _columns(sheet: Sheet, chosen: list[int]) -> Sheet:
    """Some columns of a table."""
    if len(chosen) == len(sheet.headers):
        return sheet
    return replace(
        sheet,
        headers=tuple(sheet.headers[column] for column in chosen),
        rows=tuple(tuple(row[column] for column in chosen) for row in sheet.rows),
        text_columns=tuple(place for place, column in enumerate(chosen) if column in sheet.text_columns),
    )


def _fits(sheet: Sheet, console: Console) -> bool:
    grid = _grid(sheet, _broken(sheet, _HEADER_FORMS[-1][0]), _HEADER_FORMS[-1][1])
    return _width(grid, console) <= _room(sheet, console)


def _width(grid: Table, console: Console) -> int:
    return console.measure(grid, options=console.options.update(width=_ANY_WIDTH)).maximum


def _room(sheet: Sheet, console: Console) -> int:
    return console.width + sum(_foldable(sheet, column) for column in sheet.text_columns)


def _broken(sheet: Sheet, breaks: str) -> list[str]:
    return [re.sub(breaks, "\n", header) for header in sheet.headers]


def _fitting_grid(sheet: Sheet, console: Console) -> Table:
    """A table whose headings are broken at units, dots and underscores as far as its width requires."""
    room = _room(sheet, console)
    for breaks, gap in _HEADER_FORMS:
        grid = _grid(sheet, _broken(sheet, breaks), gap)
        if _width(grid, console) <= room:
            break
    return grid


def _foldable(sheet: Sheet, column: int) -> int:
    """Characters of a column of sentences that are folded into further lines."""
    return max([0, *(len(row[column].text) + 1 - _SENTENCE_WIDTH for row in sheet.rows)])


def _grid(sheet: Sheet, headers: Sequence[str], gap: int) -> Table:
    grid = Table(box=None, pad_edge=False, padding=(0, gap, 0, 0))
    for column, header in enumerate(headers):
        if column in sheet.text_columns:
            grid.add_column(header, overflow="fold")
        else:
            grid.add_column(header.replace("\n", " \n") + " ", justify="right", overflow="fold")
    for position, row in enumerate(sheet.rows):
        if position in sheet.breaks:
            grid.add_row()
        grid.add_row(*(_shown_cell(cell, column in sheet.text_columns) for column, cell in enumerate(row)))
    return grid


def _shown_cell(cell: Cell, is_text: bool) -> Text | Folded:
    style = "bold" if cell.is_strong else ""
    return Folded(_marked(cell), style) if is_text else Text(_marked(cell), style=style)


def _marked(cell: Cell) -> str:
    """A cell with a mark, which also shows without bold type."""
    return cell.text + (cell.mark if cell.is_strong else " ")
