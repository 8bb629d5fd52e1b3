"""What the terminal shows. Results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.execution import BatchReceipt
from hydrofdi.report.formats import (
    BASELINES,
    band_note,
    baseline_title,
    delta_cells,
    failure_notes,
    lead_cells,
    lead_headers,
)
from hydrofdi.report.run_summary import RunSummary
from hydrofdi.report.table import SensitivityTable

_PLAIN_WIDTH = 100
"""Columns of text where the output is no terminal."""


def tell(message: str) -> None:
    """A message on standard error."""
    print(message, file=sys.stderr)


def write_out(text: str) -> None:
    """Text on standard output as it is."""
    sys.stdout.write(text)


def print_json(record: Any) -> None:
    """A record on standard output."""
    write_out(json.dumps(record, indent=2, allow_nan=False) + "\n")


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else _PLAIN_WIDTH, highlight=False, markup=False)


def print_run(summary: RunSummary) -> None:
    """The features of one run."""
    console = _console()
    console.print(Text(summary.title, style="bold"))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for name, value, unit in summary.lines():
        table.add_row(name, value, unit)
    console.print(table)


def print_table(table: SensitivityTable, file: Path) -> None:
    """Table 3 against both baselines."""
    console = _console()
    console.print(Text(f"{table.name}: change of the detail RMS of the chamber-1 pressure", style="bold"))
    console.print(f"from {file}\n")
    for baseline, delta in BASELINES.items():
        grid = Table(title=baseline_title(table, baseline), title_justify="left", box=None, pad_edge=False)
        for header in lead_headers(table):
            grid.add_column(header, justify="right")
        for level in range(1, table.n_level + 1):
            grid.add_column(f"δd{level} ", justify="right")
        previous = None
        for row in table.rows:
            cells = [cell if "*" in cell else f"{cell} " for cell in delta_cells(delta(row), "{}*".format)]
            if previous not in (None, row.leakage_flow):
                grid.add_row()
            previous = row.leakage_flow
            grid.add_row(*lead_cells(row), *(Text(c, style="bold" if "*" in c else "") for c in cells))
        console.print(grid)
        console.print()
    console.print(
        "* largest positive δ of the row; δ > 0: the RMS fell; sealed rows are controls without a leak"
    )
    console.print(band_note(table))
    for note in failure_notes(table):
        console.print(f"failed: {note}")


@contextmanager
def progress_bar(n_run: int) -> Iterator[Callable[[BatchReceipt], None]]:
    """A bar over runs on a terminal, nothing elsewhere; yields what to call after each batch."""
    if n_run == 0 or not sys.stderr.isatty():
        yield lambda receipt: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
        TextColumn("runs, {task.fields[failed]} failed,"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("sweep", total=n_run, failed=0)
        n_failed = 0

        def advance(receipt: BatchReceipt) -> None:
            nonlocal n_failed
            n_failed += receipt.n_failed
            progress.update(task, advance=receipt.n_run, failed=n_failed)

        yield advance
