"""Topics of machines over one connection. The broker keeps what is in no stored state yet."""

from __future__ import annotations

import socket
import time
from collections import deque
from collections.abc import Collection
from hashlib import sha256
from itertools import islice, takewhile
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.subscribeoptions import SubscribeOptions

from hydrofdi.monitor.configuration import Address, FleetConfig, MonitorConfig, Pattern
from hydrofdi.monitor.machines import SourceOf
from hydrofdi.monitor.mqtt import MqttConnection
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.monitor.sources import Inbox, Position, StreamSource, claimed
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk

_MOST_UNACKNOWLEDGED = 2**16 - 1
"""Most unacknowledged messages that the broker is asked to send, the most that MQTT allows."""

_LEAST_SIZE = 1 << 10
"""Bytes for which a small message counts, so that the number of messages is limited, too."""

LEAST_OF_ONE = 1 << 15
"""The same of a single machine."""

CAPACITY, AT_ONCE, _ENOUGH = 250 * LEAST_OF_ONE, 100 * LEAST_OF_ONE, 8 * LEAST_OF_ONE
"""Most bytes of messages that wait to be read; of a single machine, the most that are read at once, and those
that do not wait for more."""

MOST_KEPT, _MOST_OF_ONE = 60_000, 10
"""Number of unacknowledged messages beyond which machines are stored in mid-window, and that of a single one:
brokers wait after 10 (RabbitMQ) or 20 (mosquitto), or as configured."""

_STALLED = 1.0
"""Time without a message after which the broker may be waiting for acknowledgements [s]."""

_REMEMBERED = 64
"""Number of acknowledged messages that a machine can recognise; the broker may not know of the latest."""


class Message(NamedTuple):
    """A message; `number` identifies it to the broker until it is acknowledged."""

    topic: str
    payload: bytes
    number: int
    qos: int
    is_repeated: bool


class TopicSource(StreamSource):
    """The topic of a machine. A message that the broker sends again is known by a checksum.

    A broker sends messages again in their order, and with their first numbers. So those in the state can be
    left out exactly, however the clock of the machine goes.
    """

    def __init__(
        self, topic: str, config: MonitorConfig, needed: Collection[Channel], address: Address | None = None
    ) -> None:
        super().__init__(topic)
        self.address = address
        self._reader = PayloadReader(config, needed=needed)
        self._arrived: list[Message] = []
        self._client: Client | None = None
        self._known, self._seen, self._n_open = deque[int](), deque[int](), 0
        self._newest = self.stored = -1

    def open(self, position: Position) -> None:
        """Begin; the position has the checksums of messages in the state that the broker may send again."""
        self._known = deque(position.get("seen", ()))

    def take(self, number: int, client: Client, message: Message) -> None:
        """Let a message wait; numbers increase."""
        if client is not self._client:
            if self._client is not None:
                self._known, self._seen = self._seen + self._known, deque()
            self._client = client
        self._arrived.append(message)
        self._newest, self._n_open = number, self._n_open + bool(message.qos)

    def read(self, timeout: float) -> Chunk | None:
        """The samples of all messages that wait."""
        arrived, self._arrived = self._arrived, []
        payloads = [message.payload for message in arrived if self._is_new(message)]
        return self._reader.read_all(payloads) if payloads else None

    @property
    def position(self) -> Position:
        """Checksums of the messages that the broker may send again."""
        return {"seen": [*self._seen, *self._known]}

    def confirm(self) -> None:
        """All that was read is stored."""
        self.stored = self._newest

    def acknowledged(self) -> None:
        """The oldest message was acknowledged."""
        self._n_open -= 1
        while len(self._seen) > self._n_open + _REMEMBERED:
            self._seen.popleft()

    def _is_new(self, message: Message) -> bool:
        """Whether a message is in no state yet."""
        checksum, known = crc32(message.payload, message.number), self._known
        if message.qos:
            self._seen.append(checksum)
        if message.is_repeated and checksum in known:
            while known.popleft() != checksum:
                pass
            return False
        if not message.is_repeated:
            known.clear()
        return True


class _Open(NamedTuple):
    """A message that is not acknowledged; without a source, nobody needs it."""

    order: int
    client: Client
    number: int
    source: TopicSource | None


class Topics(MqttConnection):
    """A connection for the topics of all machines at a broker, at quality of service 1 in a session that
    outlives the monitor.

    The broker keeps every message until it is acknowledged. While the inbox is full, nothing is read from the
    network. Messages are acknowledged in the order in which they came, as MQTT demands, each when the state
    of its machine is stored. A state is best stored at the end of a window, when it is small: until then the
    broker keeps the messages.
    """

    def __init__(
        self, patterns: list[Pattern], config: FleetConfig, file: Path, *, is_single: bool = False
    ) -> None:
        address = patterns[0].address
        assert address is not None
        names, own = [str(pattern.address) for pattern in patterns], config.partition.replace("/", "-")
        # The same at each start; every broker accepts its 23 characters.
        text = "\n".join((socket.gethostname(), str(file.resolve()), *names, own))
        named = f"hydrofdi-{sha256(text.encode()).hexdigest()[:14]}"
        self._least_size = LEAST_OF_ONE if is_single else _LEAST_SIZE
        self._most_kept = _MOST_OF_ONE if is_single else MOST_KEPT
        self._inbox: Inbox[tuple[Client, Message]] = Inbox(CAPACITY)
        super().__init__(
            address,
            config.mqtt,
            self._inbox.say,
            config.mqtt.client_id + own if config.mqtt.client_id else named,
            SessionExpiryInterval=round(config.mqtt.session_expiry),
            ReceiveMaximum=_MOST_UNACKNOWLEDGED,
            MaximumPacketSize=16 * config.limits.payload,
        )
        self._claim: socket.socket | None = None
        self._topics = [pattern.text for pattern in patterns]
        self._was_connected, self._remark = False, ""
        self.events = self._inbox.events
        self._patterns, self._n_taken = patterns, 0
        self._open: deque[_Open] = deque()
        self._heard, self.is_behind = time.monotonic(), False

    def connect(self) -> None:
        """Begin to connect, as the only process here that has this session."""
        refusal = f"{self.address}: another process reads it, or this partition; end it, or choose another"
        self._claim = claimed(self.client_id, refusal)
        super().connect()

    def close(self) -> None:
        """End the connection; the broker keeps the session."""
        self._inbox.close()
        super().close()
        if self._claim is not None:
            self._claim.close()

    def prepare(self, client: Client) -> None:
        """Take messages."""
        client.on_message, client.on_subscribe = self._received, self._subscribed

    def connected(self, client: Client, had_session: bool) -> None:
        """Subscribe to new messages, without an earlier retained one."""
        is_forgotten = self._was_connected and not had_session
        self._remark = "; the broker kept no messages in the meantime" if is_forgotten else ""
        self._was_connected = True
        options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        client.subscribe([(topic, options) for topic in self._topics])

    def _subscribed(self, client: Client, _: Any, __: int, codes: Any, properties: Any) -> None:
        for topic, code in zip(self._topics, codes, strict=True):
            if code.is_failure:
                self.refuse(client, f"it does not let this user read {topic!r}")
                return
        is_lossy = not all(code.value for code in codes)
        lossy = "; it grants only quality of service 0, so messages can be lost" if is_lossy else ""
        self.report_connected(self._remark + lossy)

    def _received(self, client: Client, _: Any, message: MQTTMessage) -> None:
        try:
            topic = message.topic
        except UnicodeDecodeError:
            topic = ""  # of no machine
        size = max(len(message.payload), self._least_size)
        plain = Message(topic, bytes(message.payload), message.mid, message.qos, message.dup)
        self._inbox.put((client, plain), size)

    def dispatch(self, source_of: SourceOf, timeout: float = 0.0) -> None:
        """Hand the messages that have arrived, or of a single machine arrive within `timeout` seconds, to the
        sources of their machines."""
        self.is_behind = 2 * self._inbox.size > CAPACITY
        limits = (AT_ONCE, _ENOUGH) if timeout else (CAPACITY, 0)
        arrived = self._inbox.take(timeout, *limits)
        if arrived:
            self._heard = time.monotonic()
        for client, message in arrived:
            source = self._source(message.topic, source_of)
            if source is not None:
                source.take(self._n_taken, client, message)
            if message.qos:
                self._open.append(_Open(self._n_taken, client, message.number, source))
            self._n_taken += 1

    def blocking(self) -> set[TopicSource]:
        """Sources whose states must be stored although no window ended, so that messages can go on coming.

        All, if nothing comes any more, because the broker may be waiting; else so many that the number of
        unacknowledged messages stays below its limit. Some are stored early, so that not all are at once.
        """
        is_stalled, n_open = time.monotonic() - self._heard > _STALLED, len(self._open)
        if not is_stalled and n_open <= 3 * self._most_kept // 4:
            return set()
        n_over = n_open if is_stalled or n_open <= self._most_kept else n_open - self._most_kept // 2
        open_ones = (message.source for message in islice(self._open, n_over) if not _is_done(message))
        sources = [*dict.fromkeys(source for source in open_ones if source is not None)]
        return {*(sources if is_stalled or n_open > self._most_kept else sources[: 1 + len(sources) // 8])}

    def acknowledge(self) -> None:
        """Acknowledge all that is stored, up to the first message that is not."""
        done = [*takewhile(_is_done, self._open)]
        for message in done:
            self._open.popleft()
            if message.source is not None:
                message.source.acknowledged()
            message.client.ack(message.number, 1)

    def _source(self, topic: str, source_of: SourceOf) -> TopicSource | None:
        name = next(filter(None, (pattern.name_in(topic) for pattern in self._patterns)), None)
        if name is None:
            return None
        source = source_of(name, topic, lambda kind: TopicSource(topic, kind.config, kind.file.channels))
        return source if isinstance(source, TopicSource) else None


def _is_done(message: _Open) -> bool:
    return message.source is None or message.source.stored >= message.order
