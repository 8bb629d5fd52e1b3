"""Reports and runs on the terminal."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.folding import Folded
from hydrofdi.cli.terminal import tell, terminal
from hydrofdi.config import ExperimentConfig
from hydrofdi.config.idle_parameters import idle_parameters
from hydrofdi.config.plausibility import distant_baseline, unusual_values
from hydrofdi.report.document import Block, Cell, Document, Sheet
from hydrofdi.report.run_summary import RunSummary

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

_FILES_ONLY = ("provenance", "signals", "checks")
"""Sections and tables that the terminal leaves out."""

_MOST_ROWS, _FEW_ROWS = 60, 20
"""Rows up to which the terminal shows a whole table, and how many it shows of a longer one."""


def tell_doubtful_settings(
    experiment: ExperimentConfig, *, with_sweep: bool = True, with_study: bool = False
) -> None:
    """Warn of strange values, distant baselines, idle parameters, and studies that state too little."""
    sentences = unusual_values(experiment, with_sweep=with_sweep)
    sentences += distant_baseline(experiment) if with_sweep else []
    if with_study and experiment.study is not None:
        from hydrofdi.assessment.study_warnings import study_warnings

        sentences += study_warnings(experiment)
    for sentence in sentences + idle_parameters(experiment):
        tell(f"warning: {sentence}")


def print_run(summary: RunSummary) -> None:
    """The features of one run."""
    console = terminal()
    console.print(Text(summary.title, style="bold"))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for name, value, unit in summary.lines():
        table.add_row(name, value, unit)
    console.print(table)


def print_document(document: Document, file: Path) -> None:
    """A report, without the parts that only a file has room for."""
    console = terminal()
    console.print(Text(document.title, style="bold"))
    console.print(f"from {file}")
    for block in document.blocks:
        if block.key not in _FILES_ONLY and (block.paragraphs or block.sheets):
            _print_block(console, block)


def _print_block(console: Console, block: Block) -> None:
    console.print()
    console.print(Text(block.title, style="bold underline"))
    for paragraph in block.paragraphs:
        console.print(paragraph)
    for sheet in block.sheets:
        if sheet.key not in _FILES_ONLY:
            console.print()
            console.print(Text(sheet.title, style="italic"))
            console.print(_fitting_grid(_bounded(sheet), console))
            if len(sheet.rows) > _MOST_ROWS:
                console.print(_cut_sentence(len(sheet.rows)))
            if sheet.note:
                console.print(Text(sheet.note, style="dim"))


def _bounded(sheet: Sheet) -> Sheet:
    return sheet if len(sheet.rows) <= _MOST_ROWS else replace(sheet, rows=sheet.rows[:_FEW_ROWS])


def _cut_sentence(n_row: int) -> str:
    return (
        f"… the first {_FEW_ROWS} of {n_row:,} rows; --format markdown prints the whole table,"
        " --format csv and --json all runs, --out DIR writes both and Parquet."
    )


def _fitting_grid(sheet: Sheet, console: Console) -> Table:
    """A table whose headings are broken at units, dots and underscores as far as its width asks for."""
    unlimited = console.options.update(width=_ANY_WIDTH)
    room = console.width + sum(_foldable(sheet, column) for column in sheet.text_columns)
    for breaks, gap in _HEADER_FORMS:
        grid = _grid(sheet, [re.sub(breaks, "\n", header) for header in sheet.headers], gap)
        if console.measure(grid, options=unlimited).maximum <= room:
            break
    return grid


def _foldable(sheet: Sheet, column: int) -> int:
    """Characters of a column of sentences that go into further lines."""
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
    """A cell with a mark that also stands where there is no bold type."""
    return cell.text + ("*" if cell.is_strong else " ")
