"""Sessions of a client with a broker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.mqtt.address import MqttAddress
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.mqtt.security import credentials_of, tls_context

if TYPE_CHECKING:
    from paho.mqtt.client import Client

SENT_AT_ONCE = 10
"""Most messages that are sent before the broker acknowledges one; the others wait."""


@dataclass(frozen=True)
class Session:
    """Settings of a session.

    Attributes
    ----------
    client_id : str
        If it is empty, the broker assigns one.
    topic : str
        Topic to subscribe to; none if empty.
    expiry : int
        How long the broker keeps messages after the connection breaks [s].
    most_unacknowledged : int
        Most messages that the broker sends before it waits for an acknowledgement.
    largest : int
        Largest message [bytes]; the broker does not send larger ones.
    will : tuple of (str, bytes) or None
        Topic and retained message that the broker publishes when the connection breaks.
    """

    client_id: str = ""
    topic: str = ""
    expiry: int = 0
    most_unacknowledged: int = 20
    largest: int = 65_536
    will: tuple[str, bytes] | None = None


def require_paho() -> None:
    """Check that the MQTT library is installed.

    Raises
    ------
    ConfigError
        It is not installed.
    """
    try:
        import paho.mqtt.client  # noqa: F401
    except ImportError:
        raise ConfigError("mqtt:// needs paho-mqtt; pip install 'hydrofdi[monitor]'") from None


def new_client(address: MqttAddress, config: MqttConfig, session: Session) -> Client:
    """A client that is not connected.

    Raises
    ------
    ConfigError
        A file of the configuration cannot be used.
    """
    from paho.mqtt.client import Client
    from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion

    client = Client(
        CallbackAPIVersion.VERSION2,
        session.client_id,
        protocol=MQTTProtocolVersion.MQTTv5,
        reconnect_on_failure=False,
        manual_ack=True,
    )
    client.max_inflight_messages = SENT_AT_ONCE
    credentials = credentials_of(config)
    if credentials.username is not None:
        client.username_pw_set(credentials.username, credentials.password)
    if address.is_secure:
        client.tls_set_context(tls_context(config))
    if session.will is not None:
        client.will_set(*session.will, qos=1, retain=True)
    return client


def connect(client: Client, address: MqttAddress, config: MqttConfig, session: Session) -> None:
    """Connect to the broker and send the request; its answer comes later.

    Raises
    ------
    OSError
        The broker cannot be reached, or is not trusted.
    """
    from paho.mqtt.packettypes import PacketTypes
    from paho.mqtt.properties import Properties

    wishes = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
    wishes.SessionExpiryInterval = session.expiry
    wishes.ReceiveMaximum = session.most_unacknowledged
    wishes.MaximumPacketSize = session.largest
    keepalive = round(config.keepalive)
    client.connect(address.host, address.port, keepalive, clean_start=not session.expiry, properties=wishes)


def subscribe(client: Client, topic: str) -> None:
    """Subscribe to new messages of a topic, without an earlier retained one."""
    from paho.mqtt.subscribeoptions import SubscribeOptions

    options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
    client.subscribe(topic, options=options)
