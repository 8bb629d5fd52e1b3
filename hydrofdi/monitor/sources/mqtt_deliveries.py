"""Messages that a broker delivered, until it may discard them."""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass
from threading import Condition
from typing import TYPE_CHECKING

from hydrofdi.settings.counting import counted

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

MOST_UNACKNOWLEDGED = 64
"""Most unacknowledged messages that the broker is asked to send. mosquitto 2.0.11 sends many more as soon as
the first are acknowledged."""

MOST_WAITING = 1000
"""Most messages that wait to be read."""

MOST_BYTES = 32 << 20
"""Most bytes of messages that wait to be read."""

_REMEMBERED = 4 * MOST_WAITING
"""Number of messages that are recognised if they are sent again: waiting, read or lately acknowledged."""

_SHOWN = 60
"""Bytes of a malformed message that are kept."""


@dataclass
class Delivery:
    """A message. One of quality of service 1 stays with the broker until it is acknowledged.

    Attributes
    ----------
    payload : bytes
        Only the beginning if it is malformed.
    fault : str
        Why it is malformed; empty if it is not.
    number : int
                Packet identifier; 0 at quality of service 0.
    digest : int
                Hash of the payload.
    client : Client
        The connection that delivered it last and can acknowledge it.
    is_confirmed : bool
        Whether it need not be delivered again.
    """

    payload: bytes
    fault: str
    number: int
    digest: int
    client: Client
    is_confirmed: bool = False


class Deliveries:
    """The queue between the network thread and the monitor.

    At quality of service 1 nothing is lost: while the queue is full, nothing is read from the network.
    Messages that the broker sends again after a new connection are recognised. At quality of service 0, a
    full queue drops all messages until it is empty: one long gap instead of many short ones.

    Parameters
    ----------
    topic : str
    largest : int
                Largest message [bytes].
    """

    def __init__(self, topic: str, largest: int) -> None:
        self._topic, self._largest = topic, largest
        self._waiting: deque[Delivery] = deque()
        self._known: OrderedDict[int, Delivery] = OrderedDict()
        self._read: list[Delivery] = []
        self._changed = Condition()
        self._n_bytes = self._n_dropped = 0
        self._is_dropping = self._is_closed = False

    def connected(self, client: Client, had_session: bool) -> None:
        """Forget known messages if the session is new: its numbers mean other messages."""
        with self._changed:
            if not had_session:
                self._known.clear()

    def lost(self) -> None:
        """Do nothing: waiting messages can still be read."""

    def received(self, client: Client, message: MQTTMessage) -> None:
        """Queue a message, unless it was received before."""
        digest = hash(message.payload)
        with self._changed:
            known = self._known.get(message.mid) if message.qos and message.dup else None
            if known is not None and known.digest == digest:
                known.client = client
                if known.is_confirmed:
                    client.ack(known.number, 1)
                return
            fault = self._fault(message)
            payload = bytes(message.payload[:_SHOWN] if fault else message.payload)
            delivery = Delivery(payload, fault, message.mid if message.qos else 0, digest, client)
            if message.qos:
                self._changed.wait_for(self._has_room)
                self._remember(delivery)
            elif self._overflows():
                self._n_dropped += 1
                return
            self._n_bytes += len(payload)
            self._waiting.append(delivery)
            self._changed.notify_all()

    def take(self, timeout: float) -> Delivery | None:
        """The next message; None after `timeout` seconds without one."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._waiting, timeout):
                return None
            delivery = self._waiting.popleft()
            self._n_bytes -= len(delivery.payload)
            self._is_dropping = self._is_dropping and bool(self._waiting)
            if delivery.number:
                self._read.append(delivery)
            self._changed.notify_all()
            return delivery

    @property
    def n_read(self) -> int:
        """Number of messages that were taken and are not confirmed."""
        return len(self._read)

    def confirm(self) -> None:
        """Acknowledge the messages that were taken, in order."""
        with self._changed:
            for delivery in self._read:
                delivery.is_confirmed = True
                delivery.client.ack(delivery.number, 1)
            self._read.clear()

    def close(self) -> None:
        """No longer block the network thread."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def take_dropped(self) -> int:
        """Number of messages that were lost since the last call."""
        with self._changed:
            n_dropped, self._n_dropped = self._n_dropped, 0
            return n_dropped

    def _fault(self, message: MQTTMessage) -> str:
        if len(message.payload) > self._largest:
            return f"is larger than {counted(self._largest, 'byte')}"
        try:
            return "" if message.topic == self._topic else "belongs to another topic"
        except UnicodeDecodeError:
            return "belongs to another topic"

    def _remember(self, delivery: Delivery) -> None:
        self._known[delivery.number] = delivery
        self._known.move_to_end(delivery.number)
        while len(self._known) > _REMEMBERED:
            self._known.popitem(last=False)

    def _has_room(self) -> bool:
        return self._is_closed or (len(self._waiting) < MOST_WAITING and self._n_bytes < MOST_BYTES)

    def _overflows(self) -> bool:
        self._is_dropping = self._is_dropping or not self._has_room()
        return self._is_dropping
