"""Output of ``inspect`` on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table
from rich.text import Text

from hydrofdi.cli.parted_table import PartedTable
from hydrofdi.cli.records.measures_table import number_text
from hydrofdi.cli.terminal import terminal
from hydrofdi.records.overview import Overview

_MOST_SHOWN = 12
"""Most groups and labels that are listed."""


def print_overview(overview: Overview) -> None:
    """Print what a source contains."""
    console = terminal()
    console.print(Text(overview.name, style="bold"))
    console.print(_facts(overview))
    if overview.channels:
        console.print(Text("\nChannels", style="bold"))
        console.print(_channel_table(overview))
    if overview.findings:
        console.print(Text("\nRemarks", style="bold"))
        console.print(_finding_table(overview))
    else:
        console.print("\nno remarks")


def _facts(overview: Overview) -> Table:
    rates = _counts({f"{rate:g} Hz": n for rate, n in overview.sampling_frequencies.items()})
    lines = {
        "records": f"{overview.n_record:,}"
        + (f", and {overview.n_rejected:,} rejected" if overview.n_rejected else ""),
        "sampling": rates + (" (inferred)" if overview.is_inferred else ""),
        "samples": _counts({f"{length:,}": n for length, n in overview.lengths.items()}),
        "drive": _counts(
            {
                "no known period" if period is None else f"period {period:g} s": n
                for period, n in overview.drive_periods.items()
            }
        ),
        "groups": _counts(overview.groups),
        "labels": _counts(overview.labels),
    }
    table = _table(None, None)
    for name, text in lines.items():
        if text:
            table.add_row(name, text)
    return table


def _counts(counted: Mapping[Any, int]) -> str:
    """What occurs, and how often; without the number if only one thing occurs."""
    if len(counted) == 1:
        return str(next(iter(counted)))
    shown = [f"{name} ({count:,})" for name, count in list(counted.items())[:_MOST_SHOWN]]
    more = [f"and {len(counted) - _MOST_SHOWN:,} more"] if len(counted) > _MOST_SHOWN else []
    return "; ".join(shown + more)


def _channel_table(overview: Overview) -> PartedTable:
    table = PartedTable(["channel", "unit", "min", "mean", "max", "records"], n_lead=2, left=(0, 1))
    for channel, found in overview.channels.items():
        numbers = (found.least, found.mean, found.largest)
        shown = [number_text(found.shown(value)) for value in numbers]
        table.add_row(channel.value, found.shown_unit, *shown, f"{found.n_record:,}")
    return table


def _finding_table(overview: Overview) -> Table:
    table = _table("remark", "records", "for example")
    table.columns[1].justify = "right"
    for kind, finding in overview.findings.items():
        name = f"{kind} (rejected)" if finding.is_rejection else kind
        record_id, text = finding.examples[0]
        table.add_row(name, f"{finding.n_record:,}", f"{record_id}: {text}")
    return table


def _table(*headers: str | None) -> Table:
    is_headed = headers[0] is not None
    table = Table(box=None, show_header=is_headed, pad_edge=False, padding=(0, 2, 0, 0))
    for header in headers[:-1]:
        table.add_column(header or "", no_wrap=True)
    table.add_column(headers[-1] or "", overflow="fold")
    return table
