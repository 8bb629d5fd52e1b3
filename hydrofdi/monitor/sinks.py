"""Receivers of lines: standard output, metrics, messages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import Protocol, TextIO

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.lines import Event, Line, line_text
from hydrofdi.monitor.mqtt.configuration import MqttAddress, is_mqtt
from hydrofdi.monitor.mqtt.sending import MqttSink
from hydrofdi.records.streams import Chunk


class Sink(Protocol):
    """A receiver of lines: standard output, a log, a broker, a web address, metrics, a view.

    A sink that may be slow has a bounded queue of its own and never blocks the monitor; only standard output
    and the log may block it.
    """

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take the samples and the lines of a reading; return the sink's own events."""
        ...

    def close(self) -> None:
        """Send what is left, within a few seconds, and end."""
        ...


class StreamLines:
    """Writes each line as JSON, except silent ones, and flushes after each step.

    Parameters
    ----------
    stream : file object
        Standard output.
    unit : str
                Unit of scores.
    """

    def __init__(self, stream: TextIO, unit: str = "1") -> None:
        self._stream, self._unit = stream, unit

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Write lines.

        Raises
        ------
        BrokenPipeError
            Nobody reads the output any more.
        """
        if text := lines_text(lines, self._unit):
            self._stream.write(text)
            self._stream.flush()
        return ()

    def close(self) -> None:
        """Do nothing: all lines are written."""


def lines_text(lines: Sequence[Line], unit: str) -> str:
    """All lines except silent ones, as lines of JSON."""
    said = (line for line in lines if not (isinstance(line, Event) and line.is_silent))
    return "".join(line_text(line, unit) for line in said)


def open_sinks(
    config: MonitorConfig, file: DetectorFile, metrics: str | None, events: Sequence[str]
) -> list[Sink]:
    """Sinks for metrics and for events.

    Parameters
    ----------
    config : MonitorConfig
    file : DetectorFile
    metrics : str or None
        Address at which metrics are served, ``host:port``.
    events : sequence of str
        Addresses to which events are sent: ``mqtt(s)://host/topic``.

    Raises
    ------
    ConfigError
        A sink cannot be used, or an extra is not installed.
    """
    with ExitStack() as stack:
        sinks: list[Sink] = []
        for sink in _sinks(config, file, metrics, events):
            stack.callback(sink.close)
            sinks.append(sink)
        stack.pop_all()
    return sinks


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
