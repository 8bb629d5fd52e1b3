"""What the terminal shows. Results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.idle_parameters import idle_parameters
from hydrofdi.config.plausibility import unusual_values
from hydrofdi.pipeline.inspecting import Explanation
from hydrofdi.report.document import Block, Cell, Document, Sheet
from hydrofdi.report.run_summary import RunSummary
from hydrofdi.report.table import label_header
from hydrofdi.units import convert

_PLAIN_WIDTH = 100
"""Columns of text where the output is no terminal."""


_FILES_ONLY = ("provenance", "signals", "checks")
"""Sections and tables that the terminal leaves out."""


def tell(message: str) -> None:
    """A message on standard error."""
    print(message, file=sys.stderr)


def tell_doubtful_settings(experiment: ExperimentConfig, *, with_sweep: bool = True) -> None:
    """Warn of values that are far from the usual ones, and of parameters without effect."""
    for sentence in unusual_values(experiment, with_sweep=with_sweep) + idle_parameters(experiment):
        tell(f"warning: {sentence}")


def write_out(text: str) -> None:
    """Text on standard output as it is."""
    sys.stdout.write(text)


def print_json(record: Any) -> None:
    """A record on standard output."""
    write_out(json.dumps(record, indent=2, allow_nan=False) + "\n")


class _PipedConsole(Console):
    """A console whose reader may leave early, as ``head`` does."""

    def on_broken_pipe(self) -> None:
        """Leave it to the one place that knows the exit codes."""
        raise BrokenPipeError


def terminal() -> Console:
    """The console on standard output, of fixed width where it is no terminal."""
    return _PipedConsole(width=None if sys.stdout.isatty() else _PLAIN_WIDTH, highlight=False, markup=False)


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
            console.print(_grid(sheet))
            if sheet.note:
                console.print(Text(sheet.note, style="dim"))


def _grid(sheet: Sheet) -> Table:
    grid = Table(box=None, pad_edge=False)
    for column, header in enumerate(sheet.headers):
        if column in sheet.text_columns:
            grid.add_column(header, overflow="fold")
        else:
            grid.add_column(f"{header} ", justify="right", overflow="fold")
    for position, row in enumerate(sheet.rows):
        if position in sheet.breaks:
            grid.add_row()
        grid.add_row(*(Text(_marked(cell), style="bold" if cell.is_strong else "") for cell in row))
    return grid


def _marked(cell: Cell) -> str:
    """A cell with a mark that also stands where there is no bold type."""
    return cell.text + ("*" if cell.is_strong else " ")


def print_explanation(explanation: Explanation) -> None:
    """What a run was asked to do and how it went."""
    console = terminal()
    console.print(Text(f"run {explanation.run_id}, row {explanation.position}", style="bold"))
    console.print(f"status    {explanation.status} {explanation.message}".rstrip())
    for cause in explanation.causes:
        console.print(f"because   {cause}")
    console.print(f"stored in {explanation.shard or 'nothing'}")
    grid = Table(title="differs from the fixed baseline in", title_justify="left", box=None, pad_edge=False)
    for header in ("parameter", "baseline", "run"):
        grid.add_column(header)
    for name, (before, now) in explanation.differences.items():
        grid.add_row(label_header(name), _shown(before), _shown(now))
    console.print(grid if explanation.differences else "is the fixed baseline itself")
    if explanation.calibration:
        beta = convert(explanation.calibration["fluid"]["bulk_modulus"], "MPa")
        console.print(f"K_i was solved at an EBM of {beta:g} MPa, other baseline conditions alike")
    if explanation.provenance:
        made = explanation.provenance
        git = made["git"] or {"commit": "unknown", "dirty": False}
        console.print(
            f"swept {made['started']} by: {' '.join(made['command'])}\n"
            f"commit {git['commit']}{' with changes' if git['dirty'] else ''}, Python {made['python']},"
            f" seeds {made['seeds'] or 'none'}"
        )
    if explanation.log:
        console.print(explanation.log)


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else "–" if value is None else str(value)
