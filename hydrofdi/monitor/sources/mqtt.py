"""Streams of samples from an MQTT broker."""

from __future__ import annotations

import hashlib
import socket
import time
from collections.abc import Callable
from pathlib import Path

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.mqtt import MqttAddress, MqttConfig, MqttConnection
from hydrofdi.monitor.mqtt.session import Session
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.joining import joined
from hydrofdi.monitor.sources.malformed import malformed
from hydrofdi.monitor.sources.mqtt_deliveries import MOST_UNACKNOWLEDGED, Deliveries, Delivery
from hydrofdi.monitor.sources.payload import LARGEST, PayloadError
from hydrofdi.records.streams import Chunk

CONFIRM_AFTER = 5
"""Number of messages after which the state should be stored; brokers wait after 20, or as configured."""

CONFIRM_WITHIN = 1.0
"""Time after which the state should be stored [s]."""

_MOST_SAMPLES = 65_536
_MOST_MESSAGES = 1000
_SAID_AGAIN = 60.0
"""Time without losses after which they are reported again [s]."""


class MqttSource(StreamSource):
    """A topic, read at quality of service 1 in a session that outlives the monitor.

    The broker keeps every message until a state that contains its samples is stored.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    read_payload : callable
        A payload → its samples, or PayloadError.
    detector : Path
        File of the detector: monitors with other detectors have sessions of their own.
    largest : int
        Largest message [bytes]; larger ones are counted as malformed.
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        read_payload: Callable[[bytes], Chunk],
        detector: Path,
        largest: int = LARGEST,
        first_wait: float = 1.0,
    ) -> None:
        self._address, self._read_payload = address, read_payload
        self._deliveries = Deliveries(address.topic, largest)
        session = Session(
            client_id=config.client_id or _client_id(address, detector),
            topic=address.topic,
            expiry=round(config.session_expiry),
            most_unacknowledged=MOST_UNACKNOWLEDGED,
            largest=16 * largest,
        )
        self._connection = MqttConnection(address, config, session, self._deliveries, first_wait)
        self._unconfirmed_since = 0.0
        self._dropped_at = -_SAID_AGAIN

    @property
    def name(self) -> str:
        """The address."""
        return str(self._address)

    def open(self, position: Position) -> None:
        """Begin to connect; the broker knows where to continue.

        Raises
        ------
        ConfigError
            A file of the configuration cannot be used.
        """
        self._connection.open()

    def read(self, timeout: float) -> Reading:
        """The samples of the messages that have arrived."""
        chunks: list[Chunk] = []
        n_sample = n_message = 0
        delivery = self._deliveries.take(timeout)
        while delivery is not None:
            chunks.append(self._samples(delivery))
            n_sample += chunks[-1].n_time
            n_message += 1
            full = n_sample >= _MOST_SAMPLES or n_message >= _MOST_MESSAGES
            delivery = None if full else self._deliveries.take(0.0)
        events = (*self._connection.take_events(), *self._losses())
        return Reading(joined(chunks) if chunks else None, events)

    @property
    def wants_confirmation(self) -> bool:
        """Whether a few messages were read, or a second has passed since."""
        n_read = self._deliveries.n_read
        waited = time.monotonic() - self._unconfirmed_since
        return n_read >= CONFIRM_AFTER or (n_read > 0 and waited >= CONFIRM_WITHIN)

    def confirm(self) -> None:
        """Acknowledge all messages that were read."""
        self._deliveries.confirm()

    def close(self) -> None:
        """End the connection; the broker keeps the session."""
        self._deliveries.close()
        self._connection.close()

    def _samples(self, delivery: Delivery) -> Chunk:
        if self._deliveries.n_read == 1:
            self._unconfirmed_since = time.monotonic()
        try:
            if delivery.fault:
                raise PayloadError(delivery.fault)
            payload, delivery.payload = delivery.payload, delivery.payload[:60]
            return self._read_payload(payload)
        except PayloadError as error:
            return malformed("message", delivery.payload[:60].decode(errors="replace"), str(error))

    def _losses(self) -> list[Event]:
        n_dropped = self._deliveries.take_dropped()
        if not n_dropped:
            return []
        now = time.monotonic()
        is_silent = now - self._dropped_at < _SAID_AGAIN
        self._dropped_at = now
        text = "the monitor is slower than the stream: messages of quality of service 0 are lost"
        return [Event(EventKind.DROPPED, text, None, n_dropped, is_silent)]


def _client_id(address: MqttAddress, detector: Path) -> str:
    """A client id that is the same at each start; every broker accepts its 23 characters."""
    text = "\n".join((socket.gethostname(), str(detector.resolve()), str(address)))
    return f"hydrofdi-{hashlib.sha256(text.encode()).hexdigest()[:14]}"
