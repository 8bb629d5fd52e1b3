"""What the terminal shows. Results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.pipeline.inspecting import Explanation
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
from hydrofdi.report.table import SensitivityTable, label_header
from hydrofdi.units import convert

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


def terminal() -> Console:
    """The console on standard output, of fixed width where it is no terminal."""
    return Console(width=None if sys.stdout.isatty() else _PLAIN_WIDTH, highlight=False, markup=False)


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


def print_table(table: SensitivityTable, file: Path) -> None:
    """Table 3 against both baselines."""
    console = terminal()
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


def print_explanation(explanation: Explanation) -> None:
    """What a run was asked to do and how it went."""
    console = terminal()
    console.print(Text(f"run {explanation.run_id}, row {explanation.position}", style="bold"))
    console.print(f"status    {explanation.status} {explanation.message}".rstrip())
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
