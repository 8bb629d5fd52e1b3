"""Reports on the terminal."""

from __future__ import annotations

from pathlib import Path

from rich.text import Text

from hydrofdi.cli.tables import print_table, print_trimmed
from hydrofdi.cli.terminal import terminal
from hydrofdi.report.document import Document
from hydrofdi.settings.counting import counted

_FEW_ROWS = 12
"""Rows of an answer, and of a table that a page folds."""


def print_document(document: Document, file: Path, *, full: bool = False) -> None:
    """Print the answers of a report, or all of it; the answers are last."""
    console = terminal()
    console.print(Text.assemble((document.title, "bold"), f", from {file}"))
    blocks = [block for block in document.blocks if block.paragraphs or block.shown_tables]
    others = [block for block in blocks if not block.is_answer]
    for block in (others if full else []) + [block for block in blocks if block.is_answer]:
        if full:
            console.print(Text(block.title, style="bold underline"))
        for table in block.shown_tables:
            print_table(console, table, None if full and not table.is_folded else _FEW_ROWS)
        for paragraph in block.paragraphs:
            print_trimmed(console, paragraph)
    if not full and (n_table := sum(len(block.shown_tables) for block in others)):
        console.print(f"{counted(n_table, 'more table')}: --full shows them, --html writes a page.")
