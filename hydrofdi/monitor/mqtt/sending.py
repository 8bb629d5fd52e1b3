"""Lines and samples as messages that are sent at least once, without blocking the sender."""

from __future__ import annotations

import json
import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Any

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig, MqttAddress, MqttConfig, is_mqtt
from hydrofdi.monitor.lines import Event, EventKind, Line, Sink, WindowLine, line_text
from hydrofdi.monitor.mqtt.connection import MqttConnection
from hydrofdi.records.streams import Chunk

if TYPE_CHECKING:
    from paho.mqtt.client import Client

CAPACITY = 10_000
"""Most lines that wait for the broker; further ones are lost."""

AHEAD = 20
"""Most messages of samples that the broker has not acknowledged; the next one waits."""


@dataclass
class _Message:
    payload: bytes
    number: int | None = None


class Outbox(MqttConnection):
    """A bounded queue of messages; a new connection sends again what the broker did not acknowledge.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    capacity : int
        Most messages that the broker has not acknowledged.
    first_wait : float
        Wait before the second attempt to connect [s].
    status : str
        Retained topic that is ``online`` while there is a connection, and ``offline`` otherwise; unless the
        broker refuses it.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        capacity: int,
        first_wait: float = 1.0,
        status: str = "",
    ) -> None:
        self._events: deque[Event] = deque(maxlen=1000)
        super().__init__(address, config, self._events.append, first_wait=first_wait)
        self._capacity, self._status = capacity, status
        self._status_number: int | None = None
        self._messages: deque[_Message] = deque()
        self._online: Client | None = None
        self._answers: deque[tuple[Client, int, Any]] = deque()
        self._refusals: list[str] = []
        self._lock = Lock()

    def put(self, payload: bytes) -> bool:
        """Queue a message; False if there was no room."""
        with self._lock:
            self._forget_sent()
            if len(self._messages) >= self._capacity:
                return False
            self._messages.append(_Message(payload))
            self._send(self._messages[-1])
        return True

    def take_events(self) -> list[Event]:
        """Events of the connection since the last call."""
        return [self._events.popleft() for _ in range(len(self._events))]

    def take_refusals(self) -> list[str]:
        """The reason for each message that the broker refused since the last call."""
        with self._lock:
            self._forget_sent()
            refusals, self._refusals = self._refusals, []
        return refusals

    def wait_until(self, n_waiting: int, timeout: float) -> bool:
        """Wait until at most `n_waiting` messages wait; False if that takes longer than `timeout` seconds."""
        end = time.monotonic() + timeout
        while True:
            with self._lock:
                self._forget_sent()
                if len(self._messages) <= n_waiting:
                    return True
            if time.monotonic() >= end:
                return False
            time.sleep(0.005)

    def prepare(self, client: Client) -> None:
        """Note answers; the broker says when the connection breaks."""
        client.on_publish = self._answered
        if self._status:
            client.will_set(self._status, b"offline", qos=1, retain=True)

    def connected(self, client: Client, had_session: bool) -> None:
        """Send all waiting messages."""
        if self._status:
            self._status_number = client.publish(self._status, b"online", qos=1, retain=True).mid
        with self._lock:
            self._forget_sent()
            self._online = client
            for message in self._messages:
                self._send(message)
        self.report_connected()

    def _send(self, message: _Message) -> None:
        if self._online is not None:
            message.number = self._online.publish(self.address.topic, message.payload, qos=1).mid

    def _answered(self, client: Client, _: Any, number: int, code: Any, properties: Any) -> None:
        """Note an answer. paho holds a lock here that `publish` needs, so take no other lock."""
        self._answers.append((client, number, code))

    def _forget_sent(self) -> None:
        numbers = set()
        while self._answers:
            client, number, code = self._answers.popleft()
            if client is not self._online:
                continue
            numbers.add(number)
            if code.is_failure:
                self._refusals.append(code.getName().lower())
                self._status = "" if number == self._status_number else self._status
        if numbers:
            self._messages = deque(each for each in self._messages if each.number not in numbers)


class SamplePublisher(Outbox):
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
        super().__init__(address, config, AHEAD, first_wait)
        self.open()

    def send(self, chunk: Chunk, timeout: float = 1.0) -> bool:
        """Queue a block; False if there was no room in `timeout` seconds. It can then be sent again."""
        return self.wait_until(AHEAD - 1, timeout) and self.put(payload_of(chunk))

    def flush(self, timeout: float) -> bool:
        """Wait until the broker has all messages; False if that takes longer than `timeout` seconds."""
        return self.wait_until(0, timeout)


def payload_of(chunk: Chunk) -> bytes:
    """Samples as JSON: ``time`` and channels, each in SI and as an array; null if a sample is missing."""
    columns = {"time": chunk.time} | {channel.value: samples for channel, samples in chunk.channels.items()}
    numbers = {
        name: [number if math.isfinite(number) else None for number in samples.tolist()]
        for name, samples in columns.items()
    }
    return json.dumps(numbers).encode()


class MqttSink:
    """Sends lines as JSON to a topic; its ``…/status`` is ``online`` or ``offline``, and retained.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    unit : str
        Unit of scores.
    capacity : int
        Most messages that wait for the broker.
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        unit: str = "1",
        capacity: int = CAPACITY,
        first_wait: float = 1.0,
    ) -> None:
        self._unit, self._with_windows = unit, config.windows
        self._outbox = Outbox(address, config, capacity, first_wait, status=f"{address.topic}/status")
        self._said: set[str] = set()
        self._outbox.open()

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Queue the lines to send; never waits."""
        payloads = [line_text(line, self._unit).rstrip().encode() for line in lines if self._is_wanted(line)]
        n_lost = sum(not self._outbox.put(payload) for payload in payloads)
        events, refusals = self._outbox.take_events(), self._outbox.take_refusals()
        if any(event.kind is EventKind.CONNECTED for event in events):
            self._said.clear()
        if n_lost:
            reason = "lines are lost: the broker is too slow, or was unreachable for too long"
            events.append(self._dropped(reason, n_lost))
        if refusals:
            events.append(self._dropped(f"the broker refuses messages: {refusals[-1]}", len(refusals)))
        return events

    def close(self) -> None:
        """Send what is left, within three seconds."""
        self._outbox.wait_until(0, 3.0)
        self._outbox.close()

    def _dropped(self, reason: str, count: int) -> Event:
        """An event for lost lines, which is only counted if the connection lost some for the same reason."""
        is_silent = reason in self._said
        self._said.add(reason)
        return Event(EventKind.DROPPED, f"{self._outbox.address}: {reason}", None, count, is_silent)

    def _is_wanted(self, line: Line) -> bool:
        return self._with_windows if isinstance(line, WindowLine) else not line.is_silent


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
