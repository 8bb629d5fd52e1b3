"""``hydrofdi inspect``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrofdi.cli.options import Figure, Json, SamplingFrequency

if TYPE_CHECKING:
    from hydrofdi.api.inspecting import Inspection

_MOST_SHOWN = 12
"""Most groups and labels that are listed."""


def inspect(
    source: Annotated[
        Path,
        typer.Argument(
            help="A results folder, an experiment file, a description of measured files, or one data file."
        ),
    ],
    figure: Figure = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
    **settings: Any,
) -> int:
    """Inspect records: channels, rates, lengths, ranges and defects.

    Simulates at most 32 records of an experiment file (.yaml), spread evenly over its runs.
    Exit code 1 if records are rejected.
    """
    from hydrofdi.api.inspecting import inspect as look_at
    from hydrofdi.cli.terminal import print_json, tell

    found = look_at(source, sampling_frequency=sampling_frequency, **settings)
    if figure is not None:
        from hydrofdi.report.figures import save_figure

        save_figure(found.plot(), figure)
        tell(f"drew {figure}")
    if json:
        print_json(found.to_dict())
    else:
        _print(found)
    for assumption in found.assumptions:
        tell(f"note: {assumption}")
    return 1 if found.n_rejected else 0


def _print(found: Inspection) -> None:
    from rich.text import Text

    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal

    console, overview = terminal(), found.overview
    console.print(Text(overview.name, style="bold"))
    rejected = f", and {overview.n_rejected:,} rejected" if overview.n_rejected else ""
    rates = _counts({f"{rate:g} Hz": n for rate, n in overview.sampling_frequencies.items()})
    periods = overview.drive_periods.items()
    facts = {
        "records": f"{overview.n_record:,}{rejected}",
        "sampling": rates + (" (inferred)" if overview.is_inferred else ""),
        "samples": _counts({f"{length:,}": n for length, n in overview.lengths.items()}),
        "drive": _counts({f"period {each:g} s" if each else "no known period": n for each, n in periods}),
        "groups": _counts(overview.groups),
        "labels": _counts(overview.labels),
    }
    for name, text in facts.items():
        if text:
            console.print(f"{name:<10}{text}")
    for table in (found.channels, found.findings):
        if len(table):
            console.print()
            print_table(console, table)
    if not overview.findings:
        console.print("\nno remarks")


def _counts(counts: Mapping[Any, int]) -> str:
    """What occurs, and how often; without the number if only one thing occurs."""
    if len(counts) == 1:
        return str(next(iter(counts)))
    shown = [f"{name} ({count:,})" for name, count in list(counts.items())[:_MOST_SHOWN]]
    more = [f"and {len(counts) - _MOST_SHOWN:,} more"] if len(counts) > _MOST_SHOWN else []
    return "; ".join(shown + more)
