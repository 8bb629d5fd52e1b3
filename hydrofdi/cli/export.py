"""``hydrofdi export``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from hydrofdi.cli.options import SamplingFrequency, Sources
from hydrofdi.settings.counting import counted


def export(
    sources: Sources,
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE|DIR",
            help="A .csv, .parquet or .mat file for one record; otherwise a folder with a file for each.",
        ),
    ],
    sampling_frequency: SamplingFrequency = None,
    **settings: Any,
) -> int:
    """Write signals as CSV, Parquet or MAT, one file for each record.

    Headers state units, as in time [s], P1 [Pa]; measure, inspect and monitor read such files without a
    description. Exit code 1 if records are left out.
    """
    from hydrofdi.api.exporting import export as export_signals
    from hydrofdi.cli.terminal import tell

    done = export_signals(sources, out, sampling_frequency=sampling_frequency, **settings)
    n_file, n_rejected = len(done.files), len(done.rejected)
    tell(f"wrote {done.files[0]}" if n_file == 1 else f"wrote {counted(n_file, 'record')} to {out}")
    if n_rejected:
        tell(f"left out {n_rejected:,} of {counted(n_file + n_rejected, 'record')}; {done.first_rejection}")
    return 1 if n_rejected else 0
