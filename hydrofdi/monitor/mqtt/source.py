"""Streams of samples from an MQTT broker."""

from __future__ import annotations

import hashlib
import math
import socket
import time
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrofdi.monitor.configuration import MonitorConfig, MqttAddress, MqttConfig
from hydrofdi.monitor.mqtt.connection import MqttConnection
from hydrofdi.monitor.sources.contract import Inbox, Position, Reading, StreamSource, joined, malformed
from hydrofdi.monitor.sources.payload import PayloadError, PayloadReader
from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import Chunk

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

_CONFIRM_AFTER = 5
"""Number of messages after which the state should be stored; brokers wait after 20, or as configured."""

_CONFIRM_WITHIN = 1.0
"""Time after which the state should be stored [s]."""

_MOST_UNACKNOWLEDGED = 64
"""Most unacknowledged messages that the broker is asked to send. mosquitto 2.0.11 sends many more as soon as
the first are acknowledged."""

LEAST_SIZE = 1 << 15
"""Bytes for which a small message counts, so that the number of messages is limited, too."""

CAPACITY, AT_ONCE = 1000 * LEAST_SIZE, 100 * LEAST_SIZE
"""Most bytes of messages that wait to be read, and that are read at once."""


class MqttSource(StreamSource):
    """A topic, read at quality of service 1 in a session that outlives the monitor.

    The broker keeps every message until a state that contains its samples is stored. At quality of service 1
    nothing is lost: while the inbox is full, nothing is read from the network.

    Parameters
    ----------
    address : MqttAddress
    config : MonitorConfig
    detector : Path
        File of the detector: monitors with other detectors have sessions of their own.
    needed : collection of Channel
        Channels whose keys are refused, not ignored, if their unit has another dimension.
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MonitorConfig,
        detector: Path,
        needed: Collection[Channel] = (),
        first_wait: float = 1.0,
    ) -> None:
        self._address, self._reader = address, PayloadReader(config, needed=needed)
        self._inbox: Inbox[tuple[Client, MQTTMessage]] = Inbox(CAPACITY)
        self._connection = _Subscription(
            address,
            config.mqtt,
            self._inbox,
            client_id=config.mqtt.client_id or _client_id(address, detector),
            expiry=round(config.mqtt.session_expiry),
            largest=16 * config.limits.payload,
            first_wait=first_wait,
        )
        self._unconfirmed: list[tuple[Client, int]] = []
        self._unconfirmed_since, self._latest = 0.0, -math.inf

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
        messages, events = self._inbox.take(timeout, AT_ONCE)
        chunks = [self._samples(client, message) for client, message in messages]
        return Reading(joined(chunks) if chunks else None, tuple(events))

    @property
    def wants_confirmation(self) -> bool:
        """Whether a few messages were read, or a second has passed since."""
        n_read, waited = len(self._unconfirmed), time.monotonic() - self._unconfirmed_since
        return n_read >= _CONFIRM_AFTER or (n_read > 0 and waited >= _CONFIRM_WITHIN)

    def confirm(self) -> None:
        """Acknowledge all messages that were read, each to the connection that delivered it."""
        for client, number in self._unconfirmed:
            client.ack(number, 1)
        self._unconfirmed.clear()

    def close(self) -> None:
        """End the connection; the broker keeps the session."""
        self._inbox.close()
        self._connection.close()

    def _samples(self, client: Client, message: MQTTMessage) -> Chunk:
        if message.qos:
            if not self._unconfirmed:
                self._unconfirmed_since = time.monotonic()
            self._unconfirmed.append((client, message.mid))
        try:
            if message.topic != self._address.topic:
                raise PayloadError("belongs to another topic")
            chunk = self._reader.read(bytes(message.payload))
        except (PayloadError, UnicodeDecodeError) as error:
            return malformed("message", message.payload[:60].decode(errors="replace"), str(error))
        if message.dup and chunk.n_time and chunk.time[-1] <= self._latest:
            return Chunk(np.empty(0), {})  # sent again by a new connection
        self._latest = max(self._latest, float(chunk.time[-1])) if chunk.n_time else self._latest
        return chunk


class _Subscription(MqttConnection):
    """Puts the messages of a topic into an inbox."""

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        inbox: Inbox[tuple[Client, MQTTMessage]],
        **session: Any,
    ) -> None:
        super().__init__(address, config, inbox.say, most_unacknowledged=_MOST_UNACKNOWLEDGED, **session)
        self._inbox, self._was_connected, self._remark = inbox, False, ""

    def prepare(self, client: Client) -> None:
        client.on_message, client.on_subscribe = self._received, self._subscribed

    def connected(self, client: Client, had_session: bool) -> None:
        """Subscribe to new messages, without an earlier retained one."""
        from paho.mqtt.subscribeoptions import SubscribeOptions

        is_forgotten = self._was_connected and not had_session
        self._remark = "; the broker kept no messages in the meantime" if is_forgotten else ""
        self._was_connected = True
        options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        client.subscribe(self.address.topic, options=options)

    def _subscribed(self, client: Client, _: Any, __: int, codes: Any, properties: Any) -> None:
        if codes[0].is_failure:
            self.refuse(client, f"it does not let this user read {self.address.topic!r}")
            return
        is_unsafe = codes[0].value == 0
        lossy = "; it grants only quality of service 0, so messages can be lost" if is_unsafe else ""
        self.report_connected(self._remark + lossy)

    def _received(self, client: Client, _: Any, message: MQTTMessage) -> None:
        size = max(len(message.payload), LEAST_SIZE)
        self._inbox.put((client, message), size, waits=bool(message.qos))


def _client_id(address: MqttAddress, detector: Path) -> str:
    """A client id that is the same at each start; every broker accepts its 23 characters."""
    text = "\n".join((socket.gethostname(), str(detector.resolve()), str(address)))
    return f"hydrofdi-{hashlib.sha256(text.encode()).hexdigest()[:14]}"
