"""Sinks beside standard output: what texts on the command line mean."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.mqtt.address import MqttAddress, is_mqtt
from hydrofdi.monitor.sinks.contract import Sink


def open_sinks(
    config: MonitorConfig, file: DetectorFile, metrics: str | None, events: Sequence[str]
) -> list[Sink]:
    """Sinks for metrics and for events.

    Parameters
    ----------
    config : MonitorConfig
    file : DetectorFile
    metrics : str or None
        Where metrics are served, ``host:port``.
    events : sequence of str
        Where events are sent: ``mqtt(s)://host/topic`` or ``https://…``.

    Raises
    ------
    ConfigError
        One of them cannot be used, or an extra is not installed.
    """
    return [*(_events(text, config, file) for text in events)]


def _events(text: str, config: MonitorConfig, file: DetectorFile) -> Sink:
    if is_mqtt(text):
        from hydrofdi.monitor.sinks.mqtt import MqttSink

        return MqttSink(MqttAddress.parse(text), config.mqtt, file.unit)
    raise ConfigError(f"--events: {text}: give mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or https://…")
