"""Messages that are sent at least once, without blocking the sender."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage


@dataclass
class _Message:
    topic: str
    payload: bytes
    is_retained: bool
    number: int | None = None


class Outbox:
    """A bounded queue of messages; a new connection sends again what the broker did not acknowledge.

    Parameters
    ----------
    capacity : int
        Most messages that the broker has not acknowledged.
    greeting : tuple of (str, bytes), optional
        Topic and retained message that each connection sends first, unless the broker refused it before.
    """

    def __init__(self, capacity: int, greeting: tuple[str, bytes] | None = None) -> None:
        self._capacity, self._greeting = capacity, greeting
        self._messages: deque[_Message] = deque()
        self._client: Client | None = None
        self._answers: deque[tuple[Client, int, Any]] = deque()
        self._lock = Lock()
        self._greeting_number: int | None = None
        self._refusals: list[str] = []

    def put(self, topic: str, payload: bytes, is_retained: bool = False) -> bool:
        """Queue a message; False if there was no room."""
        with self._lock:
            self._forget_sent()
            if len(self._messages) >= self._capacity:
                return False
            message = _Message(topic, payload, is_retained)
            self._messages.append(message)
            self._send(message)
        return True

    @property
    def n_waiting(self) -> int:
        """Number of messages that the broker has not acknowledged."""
        with self._lock:
            self._forget_sent()
            return len(self._messages)

    def take_refusals(self) -> list[str]:
        """The reason for each message that the broker refused since the last call."""
        with self._lock:
            self._forget_sent()
            refusals, self._refusals = self._refusals, []
        return refusals

    def wait_until(self, n_waiting: int, timeout: float) -> bool:
        """Wait until at most `n_waiting` messages wait; False if that takes longer than `timeout` seconds."""
        end = time.monotonic() + timeout
        while self.n_waiting > n_waiting:
            if time.monotonic() >= end:
                return False
            time.sleep(0.005)
        return True

    def connected(self, client: Client, had_session: bool) -> None:
        """Send all waiting messages."""
        client.on_publish = self._answered
        if self._greeting:
            self._greeting_number = client.publish(*self._greeting, qos=1, retain=True).mid
        with self._lock:
            self._forget_sent()
            self._client = client
            for message in self._messages:
                self._send(message)

    def received(self, client: Client, message: MQTTMessage) -> None:
        """Do nothing: no topic is subscribed to."""

    def lost(self) -> None:
        """Keep what the broker has not acknowledged."""
        with self._lock:
            self._forget_sent()
            self._client = None

    def _send(self, message: _Message) -> None:
        if self._client is not None:
            sent = self._client.publish(message.topic, message.payload, 1, message.is_retained)
            message.number = sent.mid

    def _answered(self, client: Client, _: Any, number: int, code: Any, properties: Any) -> None:
        """Note an answer. paho holds a lock here that `publish` needs, so take no other lock."""
        self._answers.append((client, number, code))

    def _forget_sent(self) -> None:
        numbers = set()
        while self._answers:
            client, number, code = self._answers.popleft()
            if client is not self._client:
                continue
            numbers.add(number)
            if code.is_failure:
                self._refusals.append(code.getName().lower())
                self._greeting = None if number == self._greeting_number else self._greeting
        if numbers:
            self._messages = deque(each for each in self._messages if each.number not in numbers)
