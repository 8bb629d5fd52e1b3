"""``hydrofdi export``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from hydrofdi.cli.options import SamplingFrequency
from hydrofdi.settings.counting import counted


def export(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="A results folder, an experiment file (.h5, or .yaml to be simulated), a description of"
            " measured files, or one data file.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE|DIR",
            help="A .csv, .parquet or .mat file for one record; otherwise a folder with a file for each.",
        ),
    ],
    form: Annotated[
        Literal["csv", "parquet", "mat"] | None,
        typer.Option("--format", help="Format of files in a folder [default: csv]."),
    ] = None,
    channels: Annotated[
        str | None,
        typer.Option(metavar="P1,P2,…", help="Channels: P1, P2, Ps, Pr, x, v, xv, u [default: all]."),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(
            metavar="UNIT,…", help="Units such as bar,mm, each for channels of its dimension [default: SI]."
        ),
    ] = None,
    runs: Annotated[
        str | None,
        typer.Option(
            metavar="RUN,…",
            help="Positions, ranges such as 3-9, or first characters of identities [default: all].",
        ),
    ] = None,
    sampling_frequency: SamplingFrequency = None,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", help="Replace an existing file or earlier export in a folder."),
    ] = False,
) -> int:
    """Write signals as CSV, Parquet or MAT, one file for each record.

    Headers state units, as in time [s], P1 [Pa]; measure, inspect and monitor read such files without a
    description. Exit code 1 if records are left out.
    """
    from hydrofdi.api.exporting import export as export_signals
    from hydrofdi.cli.terminal import tell

    done = export_signals(
        sources,
        out,
        format=form,
        channels=channels,
        unit=unit,
        runs=runs,
        sampling_frequency=sampling_frequency,
        overwrite=overwrite,
    )
    n_file, n_rejected = len(done.files), len(done.rejected)
    tell(f"wrote {done.files[0]}" if n_file == 1 else f"wrote {counted(n_file, 'record')} to {out}")
    if n_rejected:
        tell(f"left out {n_rejected:,} of {counted(n_file + n_rejected, 'record')}; {done.first_rejection}")
    return 1 if n_rejected else 0
