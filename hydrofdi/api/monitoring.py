"""A monitor from its source to whatever shows its lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.api.arguments import names_of, path_of, refusal
from hydrofdi.api.records.sources import frequency_of
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig, MqttAddress, is_mqtt, load_monitor_config
from hydrofdi.monitor.lines import (
    Condition,
    Event,
    EventKind,
    Line,
    Sink,
    StreamLines,
    WindowLine,
    is_said,
    line_record,
)
from hydrofdi.monitor.log import WindowLog
from hydrofdi.monitor.loop import Ending, monitor
from hydrofdi.monitor.mqtt.sending import MqttSink
from hydrofdi.monitor.sources.opening import open_stream
from hydrofdi.monitor.state import StateFile
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.streams import Chunk

__all__ = ["Condition", "Event", "EventKind", "Line", "StreamLines", "WindowLine", "calls", "run_monitor"]

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
    stream = open_stream(
        name,
        settings,
        file,
        detector,
        sampling_frequency=frequency,
        is_followed=follow,
        is_resumed=state is not None,
    )
    watch = Watch(file)
    with ExitStack() as stack:
        others = [stack.enter_context(closing(sink)) for sink in _sinks(settings, file, metrics, addresses)]
        stack.pop_all()
    sinks = [shown(file, stream.name), *others]
    return monitor(
        watch,
        stream,
        sinks,
        state_file=None if state is None else StateFile(path_of(state), file, stream.name),
        log=None if log is None else WindowLog(path_of(log), file.unit),
        stop=stop,
    )


def _sinks(
    config: MonitorConfig, file: DetectorFile, metrics: str | None, events: Sequence[str]
) -> Iterator[Sink]:
    if metrics is not None:
        try:
            from hydrofdi.monitor.metrics import MetricsSink
        except ModuleNotFoundError as error:
            if error.name != "prometheus_client":
                raise
            raise ConfigError("metrics needs the extra: pip install 'hydrofdi[monitor]'") from None
        yield MetricsSink(metrics, file)
    for text in events:
        if not is_mqtt(text):
            given = text.partition("://")[0]
            raise ConfigError(f"events: {given!r}: give mqtt://HOST/TOPIC or mqtts://HOST/TOPIC")
        yield MqttSink(MqttAddress.parse(text), config.mqtt, file.unit)


def calls(on_line: OnLine | None) -> Shown:
    """Lines as mappings that a function is given."""
    return lambda file, name: _Calls(on_line, file.unit)


class _Calls:
    def __init__(self, on_line: OnLine | None, unit: str) -> None:
        self._on_line, self._unit = on_line, unit

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Hand the lines on."""
        for line in lines:
            if self._on_line is not None and is_said(line):
                self._on_line(line_record(line, self._unit))
        return ()

    def close(self) -> None:
        """Does nothing."""
