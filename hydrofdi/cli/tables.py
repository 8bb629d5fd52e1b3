"""Tables on the terminal: numbers are never cut; columns that do not fit continue below."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from hydrofdi.report.table import Column, Document, Table
from hydrofdi.settings.messages import counted

_PLAIN_WIDTH = 100
"""Columns of text if the output is not a terminal."""

_GAP, _HEADING, _SENTENCE = 2, 10, 24
"""Blanks between columns, and widths: of a line of a heading, and of folded words."""

_SEAM, _BLANK = "\ue000", "\ue001"
"""Marks of a place in a word at which it may be broken, and of a blank at which a line is not."""

_CONTROLS = dict.fromkeys([*range(0x20), *range(0x7F, 0xA0)], "�")
"""Characters of texts from outside that would act on the terminal."""


Part = str | Text | Table | tuple[Table, int | None]


def print_parts(parts: Iterable[Part]) -> None:
    """Print lines, styled ones unfolded, and tables, or the first rows of those that have a number."""
    console = terminal()
    for part in parts:
        if isinstance(part, Table):
            print_table(console, part)
        elif isinstance(part, tuple):
            print_table(console, *part)
        elif isinstance(part, Text):
            console.print(part, soft_wrap=not console.is_terminal)
        else:
            print_trimmed(console, part)


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
        print_trimmed(console, grid)
    if len(rows) < len(table):
        console.print(f"… the first {len(rows)} of {len(table):,} rows")
    for note in table.notes:
        print_trimmed(console, Text(note, style="dim"))


def print_trimmed(console: Console, shown: Grid | Text | str) -> None:
    """Print lines without blanks at their ends."""
    with console.capture() as caught:
        console.print(shown)
    lines = Text.from_ansi(caught.get()).split()
    for line in lines:
        line.rstrip()
    console.print(Text("\n").join(lines), soft_wrap=True)


def _cell(column: Column, text: str, is_strong: bool) -> Text | _Folded:
    """A text with a mark that also shows without bold type."""
    shown = text.translate(_CONTROLS) + (
        "*" if is_strong else " " if column.strong and not column.is_text else ""
    )
    return (_Folded if column.is_text else Text)(shown, "bold" if is_strong else "")


def _lines(column: Column) -> str:
    """A heading in lines, broken at blanks, dots and underscores; its unit in the last, room for a mark."""
    room = " " if column.strong and not column.is_text else ""
    name, bracket, unit = column.heading.partition(" [")
    lines = [
        *folded(name, _SENTENCE if column.is_text else _HEADING, cuts=False),
        *([f"[{unit}"] if bracket else []),
    ]
    return "\n".join(f"{line}{room}" for line in lines)


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


def folded(text: str, width: int, *, cuts: bool = True) -> list[str]:
    """A text in lines of at most `width`, broken at blanks, and long names after dots and underscores.

    A part of a name that is longer than a line is cut, or not. A mark of one character stays with the word
    before it.
    """
    kept = re.sub(r"\s+(?=\S(?:\s|$))", _BLANK, text.strip())
    parted = re.sub(
        rf"\S{{{width + 1},}}", lambda word: re.sub(r"(?<=[._])(?=[^\W\d_])", f"{_SEAM} ", word[0]), kept
    )
    lines = wrap(parted, width, break_long_words=cuts, break_on_hyphens=False)
    return [re.sub(f"{_SEAM} ?", "", line).replace(_BLANK, " ") for line in lines] or [""]


@dataclass(frozen=True)
class _Folded:
    """A table cell that is folded at the width of its column."""

    text: str
    style: str = ""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        yield Text("\n".join(folded(self.text, options.max_width)), style=self.style)

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        return Measurement(max(map(len, folded(self.text, 1, cuts=False))), len(self.text))


_FEW_ROWS = 12
"""Rows of an answer."""


def print_document(document: Document, file: Path, *, full: bool = False) -> None:
    """Print the answers of a report, or all of it; the answers are last."""
    console = terminal()
    console.print(Text.assemble((document.title, "bold"), f", from {file}"), soft_wrap=True)
    blocks = [block for block in document.blocks if block.paragraphs or block.shown_tables]
    others = [block for block in blocks if not block.is_answer]
    for block in (others if full else []) + [block for block in blocks if block.is_answer]:
        if full:
            console.print(Text(block.title, style="bold underline"))
        tables = [(table, None if full else _FEW_ROWS) for table in block.shown_tables]
        lines = [*map(Text, block.paragraphs)] if block.key == "train" else [*block.paragraphs]
        print_parts([*tables, *lines] if block.is_answer else [*lines, *tables])
    if not full and (n_table := sum(len(block.shown_tables) for block in others)):
        console.print(f"{counted(n_table, 'more table')}: --full shows them, --html writes a page.")


def terminal() -> Console:
    """The console on standard output; if that is not a terminal, as wide as ``COLUMNS`` says, or 100."""
    stated = os.environ.get("COLUMNS", "")
    width = int(stated) if stated.isdecimal() and int(stated) > 0 else None
    if width is None and not sys.stdout.isatty():
        width = _PLAIN_WIDTH
    console = Console(width=width, highlight=False, markup=False)
    console.on_broken_pipe = _raise_broken_pipe  # type: ignore[method-assign]
    return console


def _raise_broken_pipe() -> None:
    """Let `main` decide on the exit code if the reader leaves early, as ``head`` does."""
    raise BrokenPipeError
