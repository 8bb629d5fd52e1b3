"""``hydrofdi train``, ``detect``, ``monitor``, ``replay`` and ``trend``."""

from __future__ import annotations

import shlex
import signal
import sys
from collections.abc import Iterator
from heapq import nsmallest
from io import TextIOWrapper
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import hydrofdi
from hydrofdi.cli.options import Detector, Figure, Found, Json, Settings, Sources
from hydrofdi.cli.terminal import answer, draw, tell, write_out
from hydrofdi.errors import ConfigError, interruption, without_credentials
from hydrofdi.settings.messages import counted

if TYPE_CHECKING:
    from hydrofdi.detectors.file import DetectorFile
    from hydrofdi.detectors.lines import WindowLine
    from hydrofdi.detectors.windows import Tally

INTERRUPTED = 130

_MOST_ROWS = 20
"""Most windows that the terminal shows."""


def train(
    sources: Sources,
    out: Annotated[Path, typer.Option(metavar="FILE", help="JSON file to write the detector to.")],
    **settings: Any,
) -> Found:
    """Train a detector on healthy records and show the evidence for its false-alarm rate.

    Uses the records with a healthy label, the runs of a sweep without a leak, or the healthy fit records of a
    study; all records if they have no labels. If there are too few, a message says how many are needed.
    Exit code 1 if records are rejected or repeat the samples of another.
    """
    from hydrofdi.records.copies import pairs
    from hydrofdi.tables.answer import Reply

    command = shlex.join(["hydrofdi", *map(without_credentials, sys.argv[1:])])
    detector = hydrofdi.train(sources, out=out, command=command, **settings)
    left, told = detector.left_out, []
    if left.n_rejected:
        told.append(f"rejected: {counted(left.n_rejected, 'record')}; {left.first_rejection}")
    if left.n_repeated:
        told.append(f"left out as repeats: {counted(left.n_repeated, 'record')}; {pairs(left.repeats)}")
    text = f"{out}: {detector.name}\n{detector.summary}"
    return Reply({"out": out, **detector.to_dict()}, [text], told, is_sound=not told)


def train_options() -> dict[str, Any]:
    """The options of `train` that follow from the configuration of a detector."""
    from hydrofdi.cli.options import options_of
    from hydrofdi.detectors.configuration import DetectorConfig, setting_keys

    return options_of(DetectorConfig, setting_keys())


def detect(
    detector: Detector,
    sources: Sources,
    form: Annotated[
        Literal["table", "csv", "json"], typer.Option("--format", help="Output format.")
    ] = "table",
    json: Json = False,
    fail_on_alarm: Annotated[bool, typer.Option("--fail-on-alarm", help="Exit code 1 on an alarm.")] = False,
    **settings: Any,
) -> int:
    """Judge records with a trained detector, window by window, as 'hydrofdi monitor' does.

    Exit code 1 if a record has no window that is judged or novel, and on an alarm with --fail-on-alarm.
    """
    from hydrofdi.tables.answer import Reply

    tally = hydrofdi.Detector.load(detector).windows(sources, **settings)
    if json or form != "table":
        for text in tally.csv() if form == "csv" and not json else tally.json():
            write_out(text)
    else:
        answer(Reply({}, _windows(tally)))
    tell(*_told(tally))
    return 1 if tally.unjudged or (fail_on_alarm and tally.n_alarm) else 0


def _windows(tally: Tally) -> Iterator[Any]:
    """The first windows, in order; of many, alarms first, then other scores beyond a limit."""

    def place(row: tuple[int, WindowLine]) -> tuple[bool, bool, int]:
        return not row[1].alarm, not row[1].verdict.is_beyond, row[0]

    shown = [
        window for _, window in sorted(nsmallest(_MOST_ROWS, enumerate(tally), place), key=itemgetter(0))
    ]
    n_row, n_alarm = tally.n_judged + tally.faults.total(), sum(bool(window.alarm) for window in shown)
    yield tally.table(shown)
    if n_row > len(shown):
        alarms = f"{n_alarm} of {counted(tally.n_alarm, 'alarm')} among them" if n_alarm else "no alarm"
        yield f"… {len(shown)} of {counted(n_row, 'row')}, {alarms}; --format csv writes all"


def _told(tally: Tally) -> Iterator[str]:
    """Counts of windows, of alarms, and of what was not judged."""
    from hydrofdi.settings.messages import count_text, percent, percentage, time_text

    windows, rate = counted(tally.n_judged, "window"), tally.rate
    records, lasting = counted(tally.n_record, "record"), time_text(3600.0 * tally.hours)
    parts = [f"judged {windows} of {records}, {lasting}: {counted(tally.n_alarm, 'alarm')}"]
    if tally.n_judged:
        remarks = []
        if tally.rests_on:
            ends = f"{percentage(rate.low)} to {percent(rate.high)}"
            remarks.append(f"{ends}, {100.0 * rate.confidence:g} % interval over {tally.rests_on}")
        if tally.n_group > 1 and tally.rests_on != tally.group_noun:
            remarks.append(f"{tally.group_noun} are too few")
        share = percent(rate.value)
        parts.append(f"{share} ({'; '.join(remarks)})" if remarks else share)
        parts.append(f"{count_text(tally.n_alarm / tally.hours)} an hour")
    yield ", ".join(parts)
    if tally.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in tally.faults.most_common())
        beyond = f"; {tally.n_beyond:,} of them with a score beyond the limit" if tally.n_beyond else ""
        yield f"not judged: {tally.faults.total():,} ({kinds}){beyond}"
    if tally.n_alarm:
        yield tally.consequence[0]
    if tally.n_doubtful:
        yield f"doubtful: {tally.n_doubtful:,} of {windows}, such as {tally.first_doubt}"
    for (_, record), reason in list(tally.unjudged.items())[:1]:
        more = f"; {counted(len(tally.unjudged), 'record')} in all" if len(tally.unjudged) > 1 else ""
        yield f"no window of {record} was judged: {reason}{more}"


def monitor(
    detector: Annotated[
        Path,
        typer.Argument(metavar="DETECTOR|FLEET", help="Detector file, or YAML file of a fleet of machines."),
    ],
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="SOURCE",
            help="'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT;"
            " none for a fleet.",
        ),
    ] = None,
    partition: Annotated[
        str | None, typer.Option(metavar="K/N", help="Of a fleet: the k-th of n processes that share it.")
    ] = None,
    json: Json = False,
    **settings: Any,
) -> int:
    """Judge a stream with a trained detector until it ends, or the streams of a fleet.

    Writes a line of JSON to standard output for each window and for each event; a terminal shows a live view
    instead, unless --json is given. SIGTERM and Ctrl-C end it after the samples already read; with --state it
    resumes from there. Exit code 0 at the end of the stream and after SIGTERM, 1 if the stream ends and no
    window was judged, 130 after Ctrl-C.
    """

    with interruption(lambda: None) as asked:
        settings |= {"stop": lambda: bool(asked)}
        if source is None:
            for key in {"config", "sampling_frequency"} & settings.keys():
                raise ConfigError(f"{key}: of a fleet, state the keys of a configuration in {detector}")
            ending = hydrofdi.monitor_fleet(detector, partition=partition, on_line=sys.stdout, **settings)
        elif partition is not None:
            raise ConfigError("--partition: applies to a fleet, hydrofdi monitor FLEET")
        else:
            trained = hydrofdi.Detector.load(detector)
            ending = trained.monitor(source, on_line=_view(trained.file, source, json=json), **settings)
    if is_unjudged := ending.name == "UNJUDGED":
        tell(f"{source or detector}: {ending}")
    return INTERRUPTED if signal.SIGINT in asked else int(is_unjudged)


def _view(file: DetectorFile, source: str, *, json: bool) -> Any:
    """The live view on a terminal, JSON lines elsewhere."""
    if json or not sys.stdout.isatty():
        return sys.stdout
    from rich.console import Console

    from hydrofdi.cli.live_view import LiveView

    console = Console(highlight=False, markup=False)
    if console.is_dumb_terminal:
        return sys.stdout
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    return LiveView(file, without_credentials(source), console)


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
    form: Annotated[
        Literal["csv", "json"], typer.Option("--format", help="Rows, or an object for each sample.")
    ] = "csv",
    settings: Settings = None,
    **more: Any,
) -> int:
    """Replay records as a stream, to try out a monitor.

    Samples are in SI; reading them restores them exactly. Several records follow each other with a short gap.
    """
    from hydrofdi.api.streams import text_sender

    chunks = hydrofdi.replay(source, rate=rate, settings=settings or (), **more)
    send, n_sample = text_sender(form, sys.stdout), 0
    try:
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


def trend(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="Logs of 'hydrofdi monitor --log', or a description or folder of measured files with dates.",
        ),
    ],
    figure: Figure = None,
    **settings: Any,
) -> Found:
    """State since when a leak grows, how fast, and when it reaches a limit.

    Reads the log of a monitor, or measures records with dates. All statements have intervals. Nothing is
    stated for later than the length of the history after its end.
    """
    found = hydrofdi.trend(sources, **settings)
    draw(found, figure)
    return found
