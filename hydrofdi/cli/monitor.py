"""``hydrofdi monitor``."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import Detector, Json, SamplingFrequency

INTERRUPTED = 130

if TYPE_CHECKING:
    from hydrofdi.api.monitoring import Shown
    from hydrofdi.detectors.trained.file import DetectorFile
    from hydrofdi.monitor.sinks import Sink


def monitor(
    detector: Detector,
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT.",
        ),
    ],
    config: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="YAML file with the channels and the connection of the source."),
    ] = None,
    state: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="State file to resume from after a restart; without it, nothing is kept."
        ),
    ] = None,
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also append every line to this file, once.")
    ] = None,
    metrics: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="Serve metrics for Prometheus."),
    ] = None,
    events: Annotated[
        list[str] | None,
        typer.Option(metavar="URL", help="Send events to mqtt(s)://HOST/TOPIC. Repeatable."),
    ] = None,
    follow: Annotated[
        bool, typer.Option("--follow/--no-follow", help="At the end of a file, wait for more or stop.")
    ] = True,
    sampling_frequency: SamplingFrequency = None,
    json: Json = False,
) -> int:
    """Judge a stream with a trained detector until it ends.

    Writes a line of JSON to standard output for each window and for each event; a terminal shows a live view
    instead, unless --json is given. SIGTERM and Ctrl-C end it after the samples already read; with --state it
    resumes from there. Exit code 0 at the end of the stream and after SIGTERM, 1 if the stream ends and no
    sample of it could be read, 130 after Ctrl-C.
    """
    with _stop_signals() as asked:
        from hydrofdi.api.detectors.detector import Detector
        from hydrofdi.api.monitoring import run_monitor

        trained = Detector.load(detector)
        ending = run_monitor(
            trained.file,
            detector,
            source,
            _shown(json, has_state=state is not None),
            config=config,
            state=state,
            log=log,
            metrics=metrics,
            events=events or (),
            follow=follow,
            sampling_frequency=sampling_frequency,
            stop=lambda: bool(asked),
        )
    if signal.SIGINT in asked:
        return INTERRUPTED
    return int(ending.name == "UNREADABLE")


@contextmanager
def _stop_signals() -> Iterator[list[int]]:
    """In this context, Ctrl-C and SIGTERM are noted, to end after the samples read; a second one raises."""
    asked: list[int] = []

    def ask(number: int, frame: FrameType | None) -> None:
        if asked:
            raise KeyboardInterrupt
        asked.append(number)

    previous = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield asked
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def _shown(json: bool, *, has_state: bool) -> Shown:
    """The live view on a terminal, JSON lines elsewhere."""
    from hydrofdi.cli.terminal import tell

    def shown(file: DetectorFile, source: str) -> Sink:
        if not has_state:
            tell("no --state: after a restart, the monitor starts from scratch")
        return _view(json)(file, source)

    return shown


def _view(json: bool) -> Shown:
    from hydrofdi.api.monitoring import json_lines
    from hydrofdi.cli.terminal import terminal

    console = terminal()
    if json or not console.is_terminal or console.is_dumb_terminal:
        return json_lines(sys.stdout)
    from hydrofdi.cli.live_view import LiveView

    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    return lambda file, source: LiveView(file, source, console)
