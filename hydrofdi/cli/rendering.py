"""Reports and runs on the terminal."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.sheet_grids import sheet_grids
from hydrofdi.cli.terminal import terminal
from hydrofdi.report.document import Block, Document, Sheet
from hydrofdi.report.run_summary import RunSummary
from hydrofdi.report.sections.quantiles import MANY_ROWS
from hydrofdi.settings.counting import counted

_FEW_ROWS = 20
"""Most rows of a long table on the first page."""

_PAGE = 60
"""Most lines of the first page, if it has details."""


def print_run(summary: RunSummary) -> None:
    """Print the features of one run."""
    console = terminal()
    console.print(Text(summary.title, style="bold"))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for name, value, unit in summary.lines():
        table.add_row(name, value, unit)
    console.print(table)


def print_document(document: Document, file: Path, *, full: bool = False) -> None:
    """Print a report: about one page and the size of the rest, or all of it."""
    console = terminal()
    console.print(Text(document.title, style="bold"))
    console.print(f"from {file}")
    blocks = [block for block in document.blocks if block.paragraphs or block.sheets]
    shown = blocks if full else _first_page(console, blocks)
    for block in shown:
        _print_block(console, block, full)
    if not full and (more := _more(blocks, shown)):
        console.print()
        console.print(more)


def _first_page(console: Console, blocks: list[Block]) -> list[Block]:
    """The sections that are not details, and as many details as fit."""
    chosen = {block.key for block in blocks if not block.is_detail}
    room = _PAGE - sum(_height(console, block) for block in blocks if not block.is_detail)
    for block in blocks:
        if block.is_detail:
            room -= _height(console, block)
            if room < 0:
                break
            chosen.add(block.key)
    return [block for block in blocks if block.key in chosen]


def _height(console: Console, block: Block) -> int:
    """Number of lines of a section; the rows of a long detail are counted without printing."""
    n_row = sum(len(sheet.rows) for sheet in block.shown_sheets)
    if block.is_detail and n_row > _PAGE:
        return n_row
    with console.capture() as captured:
        _print_block(console, block, full=False)
    return captured.get().count("\n")


def _more(blocks: list[Block], shown: list[Block]) -> str:
    """A sentence about what the first page omits; empty if it omits nothing."""
    hidden = [
        sheet
        for block in blocks
        if block not in shown and block.key != "provenance"
        for sheet in block.sheets
    ]
    cut = [sheet for block in shown for sheet in block.sheets if _on_page(sheet) is not sheet]
    n_row = sum(len(sheet.rows) for sheet in hidden) + sum(
        len(sheet.rows) - len(_on_page(sheet).rows) for sheet in cut
    )
    if not hidden and not cut:
        return ""
    tables = f"{counted(len(hidden), 'more table')} with " if hidden else ""
    rows = counted(n_row, "row" if hidden else "more row")
    return f"… {tables}{rows}: --full shows them, --html writes a page."


def _print_block(console: Console, block: Block, full: bool) -> None:
    console.print()
    console.print(Text(block.title, style="bold underline"))
    for paragraph in block.paragraphs:
        console.print(paragraph)
    for whole in block.sheets:
        if whole.is_folded:
            console.print(f"\n{whole.title}: {len(whole.rows)}. The HTML page (--html) lists them.")
            continue
        sheet = whole if full else _on_page(whole)
        console.print()
        console.print(Text(sheet.title, style="italic"))
        for grid in sheet_grids(sheet, console):
            console.print(grid)
        if len(sheet.rows) < len(whole.shown.rows):
            console.print(f"… the first {len(sheet.rows)} of {counted(len(whole.rows), 'row')}")
        if sheet.note:
            console.print(Text(sheet.note, style="dim"))


def _on_page(sheet: Sheet) -> Sheet:
    """A table as the first page shows it."""
    if sheet.page_rows is not None:
        cut = replace(sheet, rows=sheet.rows[: sheet.page_rows], digest=None)
        return sheet if len(sheet.rows) <= sheet.page_rows else cut
    shown = sheet.shown
    return shown if len(shown.rows) <= MANY_ROWS else replace(shown, rows=shown.rows[:_FEW_ROWS])
