"""``hydrofdi replay``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from hydrofdi.cli.options import SamplingFrequency, Settings
from hydrofdi.settings.counting import counted


def replay(
    source: Annotated[
        Path,
        typer.Argument(
            help="An experiment file (.yaml to be simulated, or .h5), a results folder, a description of"
            " measured files, or one data file."
        ),
    ],
    rate: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY|max",
            help="Samples per second, e.g. 500Hz, or 'max': as fast as the reader accepts them"
            " [default: as measured].",
        ),
    ] = None,
    to: Annotated[
        str, typer.Option(metavar="-|mqtt://HOST/TOPIC", help="Standard output, or a topic of a broker.")
    ] = "-",
    form: Annotated[
        Literal["csv", "json"] | None,
        typer.Option("--format", help="Format on standard output [default: csv]."),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="YAML file with the connection to the broker, as for 'hydrofdi monitor'.",
        ),
    ] = None,
    settings: Settings = None,
    sampling_frequency: SamplingFrequency = None,
    **more: Any,
) -> int:
    """Replay records as a stream, to try out a monitor.

    Samples are in SI; reading them restores them exactly. Several records follow each other with a short gap.
    """
    from hydrofdi.api.monitoring import sample_target
    from hydrofdi.api.replaying import replay as played
    from hydrofdi.cli.terminal import tell

    chunks = played(
        source,
        rate=rate,
        settings=settings or (),
        sampling_frequency=sampling_frequency,
        **more,
    )
    n_sample = 0
    try:
        with sample_target(to, form, config, sys.stdout, tell) as send:
            for chunk in chunks:
                send(chunk)
                n_sample += chunk.n_time
    except KeyboardInterrupt:
        tell(f"stopped after {counted(n_sample, 'sample')}")
        return 0
    except BrokenPipeError:
        return 0
    tell(f"played {counted(n_sample, 'sample')}")
    return 0
