"""A monitor from its source to whatever shows its lines, and records played as streams."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, TextIO

from hydrofdi.api.arguments import names_of, path_of, refusal
from hydrofdi.api.records.sources import frequency_of
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import load_monitor_config
from hydrofdi.monitor.lines import Condition, Event, EventKind, Line, WindowLine, line_record
from hydrofdi.monitor.log import WindowLog
from hydrofdi.monitor.loop import Ending, monitor
from hydrofdi.monitor.mqtt.configuration import MqttAddress, is_mqtt
from hydrofdi.monitor.sinks import Sink, StreamLines, open_sinks
from hydrofdi.monitor.sources.opening import open_stream
from hydrofdi.monitor.state import StateFile
from hydrofdi.monitor.watch import Watch
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from hydrofdi.records.writing import titled

__all__ = ["Condition", "Event", "EventKind", "Line", "WindowLine", "calls", "json_lines", "run_monitor"]

OnLine = Callable[[dict[str, Any]], None]
Shown = Callable[[DetectorFile, str], Sink]
"""Makes what shows the lines, from the detector and the name of the source."""


def run_monitor(
    file: DetectorFile,
    detector: Path,
    source: str | PathLike[str],
    shown: Shown,
    *,
    config: str | PathLike[str] | None = None,
    state: str | PathLike[str] | None = None,
    log: str | PathLike[str] | None = None,
    metrics: str | None = None,
    events: Sequence[str] = (),
    follow: bool = True,
    sampling_frequency: str | float | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Ending:
    """Judge a stream for as long as it lasts, or until `stop` says so.

    Parameters
    ----------
    file : DetectorFile
    detector : Path
        Its file, from which a broker knows it again.
    source : str or path
        This parameter and all that follow are those of `Detector.monitor`.
    shown : callable
        Makes what the lines are given to first.
    stop : callable
        Returns whether to end; called several times a second.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the source cannot be read.
    """
    if not isinstance(metrics, str | None):
        raise refusal("metrics", "HOST:PORT", metrics)
    addresses = names_of("events", events, "addresses")
    settings = load_monitor_config(None if config is None else path_of(config))
    if state is not None and log is not None and path_of(state).resolve() == path_of(log).resolve():
        raise ConfigError(f"state and log are the same file, {state}; choose another name for one")
    frequency = frequency_of(sampling_frequency)
    name = source if isinstance(source, str) else str(path_of(source))
    stream = open_stream(name, settings, file, detector, sampling_frequency=frequency, is_followed=follow)
    watch = Watch(file)
    others = open_sinks(settings, file, metrics, addresses)
    sinks = [shown(file, stream.name), *others]
    return monitor(
        watch,
        stream,
        sinks,
        state_file=None if state is None else StateFile(path_of(state), file, stream.name),
        log=None if log is None else WindowLog(path_of(log), file.unit),
        stop=stop,
    )


def json_lines(stream: TextIO) -> Shown:
    """Lines as JSON on a stream of text."""
    return lambda file, name: StreamLines(stream, file.unit)


def calls(on_line: OnLine | None) -> Shown:
    """Lines as mappings that a function is given."""
    return lambda file, name: _Calls(on_line, file.unit)


class _Calls:
    def __init__(self, on_line: OnLine | None, unit: str) -> None:
        self._on_line, self._unit = on_line, unit

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Hand the lines on."""
        for line in lines:
            if self._on_line is not None and not getattr(line, "is_silent", False):
                self._on_line(line_record(line, self._unit))
        return ()

    def close(self) -> None:
        """Does nothing."""


Send = Callable[[Chunk], None]


@contextmanager
def sample_target(
    to: str, form: str | None, config: Path | None, stream: TextIO, tell: Callable[[str], None]
) -> Iterator[Send]:
    """Receiver of blocks of samples; it has received all when it is closed.

    Parameters
    ----------
    to : str
        ``-`` for the stream of text, or ``mqtt://host:port/topic``.
    form : {"csv", "json"}, optional
        Of text.
    config : Path, optional
        How a broker is reached.
    stream : file object
    tell : callable
        Called with messages on the connection.

    Raises
    ------
    ConfigError
        The target is neither, or a setting does not fit.
    """
    if to == "-":
        if config is not None:
            raise ConfigError("config: is for a broker; give its topic as 'to'")
        yield _text_sender(form, stream)
    elif not is_mqtt(to):
        expected = "expected '-' for standard output, or mqtt://host:port/topic"
        raise ConfigError(f"to {to}: {expected}")
    elif form is not None:
        raise ConfigError("format: is for standard output; messages are JSON")
    else:
        with _broker(to, config, tell) as send:
            yield send


def _text_sender(form: str | None, stream: TextIO) -> Send:
    """Samples as text, in SI and to the bit: JSON, or CSV with a header that comes again if it changes."""
    written: tuple[Channel, ...] = ()

    def send(chunk: Chunk) -> None:
        nonlocal written
        channels = tuple(chunk.channels)
        rows = zip(chunk.time.tolist(), *(each.tolist() for each in chunk.channels.values()), strict=True)
        if form == "json":
            names = ["time", *(channel.value for channel in channels)]
            finite = ([value if math.isfinite(value) else None for value in row] for row in rows)
            lines = [json.dumps(dict(zip(names, row, strict=True))) for row in finite]
        else:
            titles = [titled("time", "s"), *(titled(each.symbol, each.unit) for each in channels)]
            lines = [] if written == channels else [",".join(titles)]
            lines += [",".join(map(repr, row)) for row in rows]
        written = channels
        stream.writelines(f"{line}\n" for line in lines)
        stream.flush()

    return send


@contextmanager
def _broker(to: str, config: Path | None, tell: Callable[[str], None]) -> Iterator[Send]:
    from hydrofdi.monitor.mqtt.sending import SamplePublisher

    publisher = SamplePublisher(MqttAddress.parse(to), load_monitor_config(config).mqtt)

    def tell_events() -> None:
        for event in publisher.take_events():
            tell(event.text)

    def send(chunk: Chunk) -> None:
        while not publisher.send(chunk):
            tell_events()
        tell_events()

    try:
        yield send
        while not publisher.flush(1.0):
            tell_events()
    finally:
        publisher.close()
        tell_events()
