"""``hydrofdi inspect``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json, SamplingFrequency


def inspect(
    source: Annotated[
        Path,
        typer.Argument(
            help="A results folder, an experiment file, a description of measured files, or one data file."
        ),
    ],
    record: Annotated[
        str | None,
        typer.Option(
            metavar="ID", help="Record of the figure, or the beginning of its name [default: the first]."
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw one record: time, spectrum, details (.png, .svg, .pdf)."),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Inspect records: channels, rates, lengths, ranges and defects.

    Simulates at most 32 records of an experiment file (.yaml), spread evenly over its runs.
    Exit code 1 if records are rejected.
    """
    from hydrofdi.api.inspecting import inspect as look_at
    from hydrofdi.cli.records.overview_table import print_overview
    from hydrofdi.cli.terminal import print_json, tell

    found = look_at(source, record=record, sampling_frequency=sampling_frequency)
    if figure is not None:
        from hydrofdi.report.figures import save_figure

        save_figure(found.plot(), figure)
        tell(f"drew {figure}")
    if json:
        print_json(found.to_dict())
    else:
        print_overview(found.overview)
    for assumption in found.assumptions:
        tell(f"note: {assumption}")
    return 1 if found.n_rejected else 0
