"""MQTT: connections, messages that are read, and lines and samples that are sent at least once."""

from __future__ import annotations

import ssl
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from threading import Event as Signal
from typing import Any, NamedTuple

from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode

from hydrofdi.detectors.lines import Line, WindowLine
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, MqttConfig
from hydrofdi.monitor.sources import Connection, credentials, exposed, network_reason, usable
from hydrofdi.records.streams import Event, EventKind

_SENT_AT_ONCE = 10
"""Most messages that are sent before the broker acknowledges one; the others wait."""

_THIS_MACHINE = ("localhost", "127.0.0.1", "::1")


class MqttConnection(Connection):
    """A connection to a broker, with a new client each time.

    Certificates and password are read anew for each client, so that they can be renewed. `prepare`,
    `connected` and `serve` are for subclasses.
    """

    def __init__(
        self,
        address: Address,
        config: MqttConfig,
        say: Callable[[Event], None],
        client_id: str = "",
        **wishes: int,
    ) -> None:
        Connection.__init__(self, str(address), say)
        self.address, self.config, self.client_id, self._wishes = address, config, client_id, wishes
        self.changed = Signal()
        self._is_lost, self._reason = False, ""

    def connect(self) -> None:
        """Begin to connect."""
        self._new_client()
        self.begin(self._doubts())

    def close(self) -> None:
        """Disconnect and end; wait for an answer for three seconds at most."""
        self.is_closing.set()
        self.changed.set()
        self.end(3.0)

    def prepare(self, client: Client) -> None:
        """Set the callbacks of a new client; they run in the network thread, which receives nothing then."""

    def connected(self, client: Client, had_session: bool) -> None:
        """The broker has accepted a client; with a session, it kept messages."""

    def serve(self, client: Client) -> None:
        """Something changed while there is a client; it may not be connected yet, or not any more."""

    def refuse(self, client: Client, reason: str) -> None:
        """End a connection that is of no use; the broker publishes what the client wants said of it then."""
        self._reason = reason
        client.disconnect(ReasonCode(PacketTypes.DISCONNECT, "Disconnect with will message"))

    def connect_once(self) -> str:
        """Connect with a new client."""
        self._is_lost, self._reason = False, ""
        wishes = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        for name, wish in self._wishes.items():
            setattr(wishes, name, wish)
        is_new = not self._wishes.get("SessionExpiryInterval")
        host, port, keepalive = self.address.host, self.address.port, round(self.config.keepalive)
        try:
            client = self._new_client()
            client.connect(host, port, keepalive, clean_start=is_new, properties=wishes)
        except OSError as error:
            return network_reason(error)
        except ValueError as error:  # paho's, or a file that cannot be used any more
            return str(error) if isinstance(error, ConfigError) else "the connection failed"
        client.loop_start()
        while not self._is_lost:
            self.changed.wait(1.0)
            self.changed.clear()
            if self.is_closing.is_set():
                self.refuse(client, "")
            self.serve(client)
        client.loop_stop()
        return self._reason

    def _doubts(self) -> Iterator[str]:
        address, config = self.address, self.config
        yield from exposed(config.password_file, config.key)
        if address.scheme == "mqtts" and not config.verify:
            yield f"mqtt.verify is false: the certificate of {address.host} is not checked"
        is_open = address.scheme == "mqtt" and address.host not in _THIS_MACHINE
        if is_open and credentials("mqtt", config.username, config.password_file)[1]:
            yield f"the password goes to {address.host} without encryption; use mqtts://"

    def _new_client(self) -> Client:
        client = Client(
            CallbackAPIVersion.VERSION2,
            self.client_id,
            protocol=MQTTProtocolVersion.MQTTv5,
            reconnect_on_failure=False,
            manual_ack=True,
        )
        username, password = credentials("mqtt", self.config.username, self.config.password_file)
        if username:
            client.username_pw_set(username, password or None)
        if self.address.scheme == "mqtts":
            client.tls_set_context(_tls_context(self.config))
        client.on_connect, client.on_disconnect = self._on_connect, self._on_disconnect
        self.prepare(client)
        return client

    def _on_connect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        if code.is_failure:
            self._reason = f"it says {code.getName().lower()!r}"
        else:
            self.connected(client, flags.session_present)

    def _on_disconnect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        says = f"it says {code.getName().lower()!r}" if flags.is_disconnect_packet_from_server else ""
        self._reason = self._reason or says or "the broker closed the connection, or the network broke it"
        self._is_lost = True
        self.changed.set()


def _tls_context(config: MqttConfig) -> ssl.SSLContext:
    if config.ca_file is None:
        context = ssl.create_default_context()
    else:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        with usable("mqtt.ca_file", config.ca_file):
            context.load_verify_locations(config.ca_file)
    if config.certificate is not None:
        with usable("mqtt.certificate", config.certificate):
            context.load_cert_chain(config.certificate, config.key, password="")
    if not config.verify:
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    return context


class Message(NamedTuple):
    """A message; `number` identifies it to the broker until it is acknowledged."""

    topic: str
    payload: bytes
    number: int
    qos: int
    is_repeated: bool


class Publisher(MqttConnection):
    """A bounded queue of messages; a new connection sends again what the broker did not acknowledge.

    `events` are those of the connection, and messages that the broker refused.
    """

    _status = ""

    def __init__(self, address: Address, config: MqttConfig, capacity: int = 10_000) -> None:
        self.events: deque[Event] = deque(maxlen=1000)
        self._capacity = capacity
        self._payloads: deque[bytes] = deque()
        self._sent: deque[int] = deque()
        self._answers: deque[tuple[int, Any]] = deque()
        self._is_online = False
        super().__init__(address, config, self.events.append)
        self.connect()

    def send(self, payload: bytes) -> bool:
        """Queue a message; False if there was no room."""
        if len(self._payloads) >= self._capacity:
            return False
        self._payloads.append(payload)
        self.changed.set()
        return True

    def wait_until(self, n_waiting: int, timeout: float) -> bool:
        """Wait until at most `n_waiting` messages wait; False if that takes longer than `timeout` seconds."""
        end = time.monotonic() + timeout
        while len(self._payloads) > n_waiting and time.monotonic() < end:
            time.sleep(0.005)
        return len(self._payloads) <= n_waiting

    def prepare(self, client: Client) -> None:
        """Note answers; the broker says when the connection breaks."""
        self._sent.clear()
        self._answers.clear()
        self._is_online = False
        client.on_publish = self._answered
        if self._status:
            client.will_set(self._status, b"offline", qos=1, retain=True)

    def connected(self, client: Client, had_session: bool) -> None:
        """Send all waiting messages."""
        if self._status:
            client.publish(self._status, b"online", qos=1, retain=True)
        self._is_online = True
        self.changed.set()
        self.report_connected()

    def serve(self, client: Client) -> None:
        """Forget what was answered, and send more."""
        while self._answers:
            number, code = self._answers.popleft()
            if number in self._sent:  # else it is that of the status
                index = self._sent.index(number)
                del self._sent[index], self._payloads[index]
                if code.is_failure:
                    self.say(self.dropped(f"the broker refuses messages: {code.getName().lower()}"))
        while self._is_online and len(self._sent) < min(len(self._payloads), _SENT_AT_ONCE):
            payload = self._payloads[len(self._sent)]
            self._sent.append(client.publish(self.address.path, payload, qos=1).mid)

    def dropped(self, reason: str, count: int = 1) -> Event:
        """An event for lost messages; it is only counted if the connection lost some for the same reason."""
        is_silent = reason in self.said
        self.said.add(reason)
        return Event(EventKind.DROPPED, f"{self.address}: {reason}", None, count, is_silent)

    def _answered(self, client: Client, _: Any, number: int, code: Any, properties: Any) -> None:
        self._answers.append((number, code))
        self.changed.set()


class MqttSink(Publisher):
    """Sends lines as JSON to a topic; its ``…/status`` is ``online`` or ``offline``, and retained."""

    def __init__(self, address: Address, config: MqttConfig, capacity: int = 10_000) -> None:
        self._status = f"{address.path}/status"
        super().__init__(address, config, capacity)

    def wants(self, line: Line) -> bool:
        """Whether it sends such a line."""
        return self.config.windows if isinstance(line, WindowLine) else not line.is_silent

    def send_all(self, texts: Sequence[str]) -> list[Event]:
        """Queue texts of lines to send, without waiting; what happened to those before."""
        n_lost = sum(not self.send(text.rstrip().encode()) for text in texts)
        events = [self.events.popleft() for _ in range(len(self.events))]
        if n_lost:
            reason = "lines are lost: the broker is too slow, or was unreachable for too long"
            events.append(self.dropped(reason, n_lost))
        return events

    def close(self) -> None:
        """Send what is left, within three seconds."""
        self.wait_until(0, 3.0)
        super().close()
