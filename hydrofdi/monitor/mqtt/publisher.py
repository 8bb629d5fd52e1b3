"""Samples as messages, to try a monitor."""

from __future__ import annotations

import json
import math

from hydrofdi.monitor.lines import Event
from hydrofdi.monitor.mqtt.address import MqttAddress
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.mqtt.connection import MqttConnection
from hydrofdi.monitor.mqtt.outbox import Outbox
from hydrofdi.monitor.mqtt.session import Session
from hydrofdi.records.batch import Array
from hydrofdi.records.streams import Chunk

AHEAD = 20
"""Most messages that the broker has not acknowledged; the next one waits."""


class SamplePublisher:
    """Sends blocks of samples, each as one message, no faster than the broker accepts them.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    first_wait : float
                Wait before the second attempt to connect [s].

    Raises
    ------
    ConfigError
        A file of the configuration cannot be used.
    """

    def __init__(self, address: MqttAddress, config: MqttConfig, first_wait: float = 1.0) -> None:
        self._topic = address.topic
        self._outbox = Outbox(AHEAD)
        self._connection = MqttConnection(address, config, Session(), self._outbox, first_wait)
        self._connection.open()

    def send(self, chunk: Chunk, timeout: float = 1.0) -> bool:
        """Queue a block; False if there was no room in `timeout` seconds. It can then be sent again."""
        return self._outbox.wait_until(AHEAD - 1, timeout) and self._outbox.put(
            self._topic, payload_of(chunk)
        )

    def take_events(self) -> tuple[Event, ...]:
        """Events of the connection since the last call."""
        return self._connection.take_events()

    def flush(self, timeout: float) -> bool:
        """Wait until the broker has all messages; False if that takes longer than `timeout` seconds."""
        return self._outbox.wait_until(0, timeout)

    def close(self) -> None:
        """End the connection."""
        self._connection.close()


def payload_of(chunk: Chunk) -> bytes:
    """Samples as JSON: ``time`` and channels, each in SI and as an array; null if a sample is missing."""
    columns = {"time": chunk.time} | {channel.value: samples for channel, samples in chunk.channels.items()}
    return json.dumps({name: _numbers(samples) for name, samples in columns.items()}).encode()


def _numbers(samples: Array) -> list[float | None]:
    return [number if math.isfinite(number) else None for number in samples.tolist()]
