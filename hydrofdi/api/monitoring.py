"""What receives the lines of a monitor: functions, metrics, brokers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from typing import Any

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig, MqttAddress, is_mqtt
from hydrofdi.monitor.lines import Line, Sink, is_said, line_record
from hydrofdi.monitor.mqtt.sending import MqttSink
from hydrofdi.records.streams import Chunk


def open_sinks(
    config: MonitorConfig, file: DetectorFile, metrics: str | None, events: Sequence[str]
) -> list[Sink]:
    """Sinks for metrics and for events; none stays open if one cannot be opened.

    Raises
    ------
    ConfigError
        An address is wrong, or a library is not installed.
    """
    with ExitStack() as stack:
        sinks = [stack.enter_context(closing(sink)) for sink in _sinks(config, file, metrics, events)]
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


class Calls:
    """A sink that calls a function with each line."""

    def __init__(self, on_line: Callable[[dict[str, Any]], None] | None, unit: str) -> None:
        self._on_line, self._unit = on_line, unit

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Hand the lines on."""
        for line in lines:
            if self._on_line is not None and is_said(line):
                self._on_line(line_record(line, self._unit))
        return ()

    def close(self) -> None:
        """Does nothing."""
