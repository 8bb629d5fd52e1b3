"""Connections to a broker of MQTT."""

from __future__ import annotations

import ssl
from collections.abc import Callable, Iterator
from threading import Event as Signal
from typing import Any

from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, MqttConfig
from hydrofdi.monitor.sources import Connection, credentials, exposed, network_reason, usable
from hydrofdi.records.streams import Event

_THIS_MACHINE = ("localhost", "127.0.0.1", "::1")


class MqttConnection(Connection):
    """A connection to a broker, with a new client each time.

    Certificates and password are read anew for each client, so that they can be renewed. `prepare` and
    `connected` are for subclasses.
    """

    def __init__(
        self,
        address: Address,
        config: MqttConfig,
        say: Callable[[Event], None],
        client_id: str,
        **wishes: int,
    ) -> None:
        super().__init__(str(address), say)
        self.address, self.config, self.client_id, self._wishes = address, config, client_id, wishes
        self._client: Client | None = None
        self._is_lost, self._reason = Signal(), ""

    def connect(self) -> None:
        """Begin to connect."""
        self._new_client()
        self.begin(self._doubts())

    def close(self) -> None:
        """Disconnect and end; wait for an answer for three seconds at most."""
        self.is_closing.set()
        if self._client is not None:
            self._client.disconnect()
        self.end(3.0)

    def prepare(self, client: Client) -> None:
        """Set the callbacks of a new client; they run in the network thread, which receives nothing then."""

    def connected(self, client: Client, had_session: bool) -> None:
        """The broker has accepted a client; with a session, it kept messages."""

    def refuse(self, client: Client, reason: str) -> None:
        """End a connection that is of no use."""
        self._reason = reason
        client.disconnect()

    def connect_once(self) -> str:
        """Connect with a new client."""
        self._is_lost.clear()
        self._reason = ""
        wishes = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
        for name, wish in self._wishes.items():
            setattr(wishes, name, wish)
        is_new = not self._wishes.get("SessionExpiryInterval")
        host, port, keepalive = self.address.host, self.address.port, round(self.config.keepalive)
        try:
            self._client = client = self._new_client()
            client.connect(host, port, keepalive, clean_start=is_new, properties=wishes)
        except OSError as error:
            return network_reason(error)
        except ValueError as error:  # paho's, or a file that cannot be used any more
            return str(error) if isinstance(error, ConfigError) else "the connection failed"
        client.loop_start()
        if self.is_closing.is_set():  # since before there was a connection
            client.disconnect()
        self._is_lost.wait()
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
        self._is_lost.set()


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
