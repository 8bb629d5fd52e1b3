"""``hydrofdi monitor``."""

from __future__ import annotations

import signal
import sys
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Json, SamplingFrequency, frequency

INTERRUPTED = 130

if TYPE_CHECKING:
    from hydrofdi.detectors.trained import DetectorFile
    from hydrofdi.monitor.sinks import Sink


def monitor(
    detector: Annotated[Path, typer.Argument(metavar="DETECTOR.json", help="File of 'hydrofdi train'.")],
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT.",
        ),
    ],
    config: Annotated[
        Path | None,
        typer.Option(metavar="FILE.yaml", help="Channels of the source, and how it is reached."),
    ] = None,
    state: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Where to go on after a restart; nothing is kept without."),
    ] = None,
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also append all lines to this file, each once.")
    ] = None,
    metrics: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="Serve metrics for Prometheus."),
    ] = None,
    events: Annotated[
        list[str] | None,
        typer.Option(metavar="URL", help="Send events to mqtt(s)://HOST/TOPIC or https://… Repeatable."),
    ] = None,
    follow: Annotated[
        bool, typer.Option("--follow/--no-follow", help="Wait for more at the end of a file, or end there.")
    ] = True,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Judge a stream with a trained detector, for as long as it lasts.

    A line of JSON for each window and for each event goes to standard output; on a terminal, a live view is
    shown instead, unless --json is given. SIGTERM and Ctrl-C end it after the samples that it has read, and
    with --state it goes on from there. Exit code 0 at the end of the stream and after SIGTERM, 1
    where the stream is over and no sample of it could be read, 130 after Ctrl-C.
    """
    from hydrofdi.monitor.stopping import StopSignals

    with StopSignals() as stop:
        from hydrofdi.cli.terminal import tell
        from hydrofdi.detectors.trained.reading import load_detector
        from hydrofdi.monitor.configuration import load_monitor_config
        from hydrofdi.monitor.loop import Ending
        from hydrofdi.monitor.loop import monitor as watch_stream
        from hydrofdi.monitor.sinks.log import WindowLog
        from hydrofdi.monitor.sinks.opening import open_sinks
        from hydrofdi.monitor.sources.opening import open_stream
        from hydrofdi.monitor.state import StateFile
        from hydrofdi.monitor.watch import Watch

        file, settings = load_detector(detector), load_monitor_config(config)
        stream = open_stream(
            source,
            settings,
            file,
            detector,
            sampling_frequency=frequency(sampling_frequency),
            is_followed=follow,
        )
        watch = Watch(file)
        sinks = [_shown(file, stream.name, json), *open_sinks(settings, file, metrics, events or ())]
        if state is None:
            tell("no --state: after a restart, it begins anew")
        ending = watch_stream(
            watch,
            stream,
            sinks,
            state_file=None if state is None else StateFile(state, file, stream.name),
            log=None if log is None else WindowLog(log, file.unit),
            stop=stop,
        )
    if stop.number == signal.SIGINT:
        return INTERRUPTED
    return int(ending is Ending.UNREADABLE)


def _shown(file: DetectorFile, source: str, json: bool) -> Sink:
    """The live view on a terminal, JSON lines elsewhere."""
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.monitor.sinks.stream_lines import StreamLines

    console = terminal()
    if json or not console.is_terminal or console.is_dumb_terminal:
        return StreamLines(sys.stdout, file.unit)
    from hydrofdi.cli.monitor.live import LiveView

    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    return LiveView(file, source, console)
