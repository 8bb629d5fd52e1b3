"""Sinks beside standard output, from texts on the command line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.mqtt.address import MqttAddress, is_mqtt
from hydrofdi.monitor.sinks.contract import Sink
from hydrofdi.monitor.sinks.metrics import MetricsSink
from hydrofdi.monitor.sinks.mqtt import MqttSink


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
        yield MetricsSink(metrics, file)
    for text in events:
        if not is_mqtt(text):
            given = text.partition("://")[0]
            raise ConfigError(f"events: {given!r}: give mqtt://HOST/TOPIC or mqtts://HOST/TOPIC")
        address, with_windows = MqttAddress.parse(text), config.mqtt.windows
        yield MqttSink(address, config.mqtt, file.unit, with_windows=with_windows)
