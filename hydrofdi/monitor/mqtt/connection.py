"""A connection to a broker that reconnects automatically."""

from __future__ import annotations

import random
import ssl
import time
from collections.abc import Callable
from threading import Event as Signal
from threading import Thread
from typing import TYPE_CHECKING, Any

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MqttAddress, MqttConfig
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.security import credentials, exposed, network_reason, usable

if TYPE_CHECKING:
    from paho.mqtt.client import Client

_LONGEST_WAIT = 120.0
"""Longest wait between attempts [s]."""

_STEADY = 60.0
"""Duration of a stable connection [s]; after it, the first new attempt comes soon."""

_SENT_AT_ONCE = 10
"""Most messages that are sent before the broker acknowledges one; the others wait."""

_THIS_MACHINE = ("localhost", "127.0.0.1", "::1")


class MqttConnection:
    """Keeps a connection to a broker, with a new client each time, and reports when it is made or lost.

    Certificates and password are read anew for each client, so that they can be renewed. `prepare` and
    `connected` are for subclasses.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    say : callable
        Takes events.
    first_wait : float
        Wait after the first failure [s]; it doubles up to two minutes, minus a random part.
    client_id : str
        If it is empty, the broker assigns one.
    expiry : int
        How long the broker keeps the session after the connection breaks [s].
    most_unacknowledged : int
        Most messages that the broker sends before it waits for an acknowledgement.
    largest : int
        Largest message [bytes]; the broker does not send larger ones.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        say: Callable[[Event], None],
        *,
        first_wait: float = 1.0,
        client_id: str = "",
        expiry: int = 0,
        most_unacknowledged: int = 20,
        largest: int = 65_536,
    ) -> None:
        self.address, self.config, self._say, self._first_wait = address, config, say, first_wait
        self.client_id, self._expiry = client_id, expiry
        self._most_unacknowledged, self._largest = most_unacknowledged, largest
        self._is_closed, self._is_over = Signal(), Signal()
        self._client: Client | None = None
        self._reason = ""
        self._said: set[str] = set()
        self._thread = Thread(target=self._keep, name=f"mqtt {address.broker}", daemon=True)

    def open(self) -> None:
        """Begin to connect.

        Raises
        ------
        ConfigError
            A file of the configuration cannot be used, or paho-mqtt is not installed. A broker that does not
            answer is not an error.
        """
        self._new_client()
        address, config = self.address, self.config
        doubts = [*exposed(config.password_file, config.key)]
        if address.is_secure and not config.verify:
            doubts.append(f"mqtt.verify is false: the certificate of {address.broker} is not checked")
        is_open = not address.is_secure and address.host not in _THIS_MACHINE
        if is_open and credentials("mqtt", config.username, config.password_file)[1]:
            doubts.append(f"the password goes to {address.broker} without encryption; use mqtts://")
        for doubt in doubts:
            self._say(Event(EventKind.INSECURE, doubt))
        self._thread.start()

    def close(self, timeout: float = 3.0) -> None:
        """Disconnect and end; wait for an answer for `timeout` seconds at most."""
        self._is_closed.set()
        if client := self._client:
            _disconnect(client)
        if self._thread.is_alive():
            self._thread.join(timeout)
        self._is_over.set()

    def prepare(self, client: Client) -> None:
        """Set the callbacks of a new client; they run in the network thread, which receives nothing then."""

    def connected(self, client: Client, had_session: bool) -> None:
        """The broker has accepted a client; with a session, it kept messages."""
        self.report_connected()

    def report_connected(self, remark: str = "") -> None:
        """Report a connection."""
        self._said.clear()
        self._say(Event(EventKind.CONNECTED, f"connected to {self.address}{remark}"))

    def refuse(self, client: Client, reason: str) -> None:
        """End a connection that is of no use."""
        self._reason = reason
        _disconnect(client)

    def _keep(self) -> None:
        n_failed = 0
        while not self._is_closed.is_set():
            began = time.monotonic()
            reason = self._connect_once()
            if reason not in self._said and not self._is_closed.is_set():
                self._said.add(reason)
                text = f"no connection to {self.address}: {reason}; trying again"
                self._say(Event(EventKind.DISCONNECTED, text))
            n_failed = 0 if time.monotonic() - began > _STEADY else n_failed + 1
            longest = min(_LONGEST_WAIT, self._first_wait * 2.0 ** min(n_failed, 16))
            self._is_closed.wait(longest * random.uniform(0.5, 1.0))

    def _connect_once(self) -> str:
        """Why the connection ended, or could not be made."""
        self._reason = ""
        self._is_over.clear()
        try:
            client = self._new_client()
            self._connect(client)
        except OSError as error:
            return network_reason(error)
        except ValueError as error:  # paho's, or a file that cannot be used any more
            return str(error) if isinstance(error, ConfigError) else "the connection failed"
        self._client = client
        client.loop_start()
        while not self._is_over.wait(1.0):
            if self._is_closed.is_set():
                _disconnect(client)
        client.loop_stop()
        self._client = None
        return self._reason

    def _new_client(self) -> Client:
        try:
            from paho.mqtt.client import Client
            from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
        except ImportError:
            raise ConfigError("mqtt:// needs paho-mqtt; pip install 'hydrofdi[monitor]'") from None
        client = Client(
            CallbackAPIVersion.VERSION2,
            self.client_id,
            protocol=MQTTProtocolVersion.MQTTv5,
            reconnect_on_failure=False,
            manual_ack=True,
        )
        client.max_inflight_messages = _SENT_AT_ONCE
        username, password = credentials("mqtt", self.config.username, self.config.password_file)
        if username:
            client.username_pw_set(username, password or None)
        if self.address.is_secure:
            client.tls_set_context(_tls_context(self.config))
        client.on_connect, client.on_disconnect = self._on_connect, self._on_disconnect
        self.prepare(client)
        return client

    def _connect(self, client: Client) -> None:
        from paho.mqtt.packettypes import PacketTypes
        from paho.mqtt.properties import Properties

        wishes = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        wishes.SessionExpiryInterval = self._expiry
        wishes.ReceiveMaximum = self._most_unacknowledged
        wishes.MaximumPacketSize = self._largest
        keepalive, host, port = round(self.config.keepalive), self.address.host, self.address.port
        client.connect(host, port, keepalive, clean_start=not self._expiry, properties=wishes)

    def _on_connect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        if code.is_failure:
            self._reason = f"it says {code.getName().lower()!r}"
        else:
            self.connected(client, flags.session_present)

    def _on_disconnect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        says = f"it says {code.getName().lower()!r}" if flags.is_disconnect_packet_from_server else ""
        self._reason = self._reason or says or "the broker closed the connection, or the network broke it"
        self._is_over.set()


def _disconnect(client: Client) -> None:
    """End a connection; the broker publishes what the client wants said of it then."""
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.reasoncodes import ReasonCode

    client.disconnect(ReasonCode(PacketTypes.DISCONNECT, "Disconnect with will message"))


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
