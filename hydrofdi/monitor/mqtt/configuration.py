"""Addresses of topics, ``mqtt://host:port/topic``, and settings of connections to brokers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self
from urllib.parse import unquote, urlsplit

from pydantic import Field, model_validator

from hydrofdi.errors import ConfigError
from hydrofdi.settings.quantities import SI, Section

_PORTS = {"mqtt": 1883, "mqtts": 8883}


def is_mqtt(text: str) -> bool:
    """Whether a text is meant as an address of MQTT."""
    return text.partition("://")[0].lower() in _PORTS and "://" in text


@dataclass(frozen=True)
class MqttAddress:
    """A topic of a broker.

    Attributes
    ----------
    host : str
    port : int
    topic : str
    is_secure : bool
        Whether the connection is encrypted (``mqtts``).
    """

    host: str
    port: int
    topic: str
    is_secure: bool

    @classmethod
    def parse(cls, text: str) -> Self:
        """The address in a text such as ``mqtts://broker.example/press/samples``; by default on this machine.

        Raises
        ------
        ConfigError
            It is not such an address, does not name a single topic, or contains ``@`` as for credentials
            (write ``%40`` in a topic).
        """
        scheme, _, rest = text.partition("://")
        place, _, topic = rest.partition("/")
        if "@" in rest:
            raise ConfigError(
                f"{scheme}://…: all users of the machine can see credentials in an address; use"
                " 'mqtt.password_file', or HYDROFDI_MQTT_USERNAME and HYDROFDI_MQTT_PASSWORD"
                " (in a topic, write %40)"
            )
        try:
            parts = urlsplit(f"//{place}")
            host, port = parts.hostname or "localhost", parts.port
            host.encode("idna")
        except ValueError:
            raise ConfigError(f"{text}: expected mqtt://host:port/topic") from None
        topic = unquote(topic)
        if scheme.lower() not in _PORTS or not topic or "\0" in topic:
            raise ConfigError(f"{text}: expected mqtt://host:port/topic, or mqtts:// for TLS")
        if "+" in topic or "#" in topic:
            raise ConfigError(f"{text}: names several topics; a stream is one topic, without '+' and '#'")
        return cls(host, port or _PORTS[scheme.lower()], topic, scheme.lower() == "mqtts")

    @property
    def broker(self) -> str:
        """Host and port."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def __str__(self) -> str:
        return f"{'mqtts' if self.is_secure else 'mqtt'}://{self.broker}/{self.topic}"


class MqttConfig(Section):
    """Connections to MQTT 5 brokers. Messages are sent and read at quality of service 1."""

    client_id: str = Field(default="", max_length=128)
    """Name under which the broker keeps the messages of a source while the monitor is disconnected. Two
    clients with the same name disconnect each other. By default a digest of the name of the machine, the path
    of the detector and the topic."""

    keepalive: Annotated[float, SI("s", least=5.0, most=3600.0)] = 30.0
    """A connection without a response for about this time [s] is closed."""

    session_expiry: Annotated[float, SI("s", least=0.0, most=4.0e9)] = 604_800.0
    """How long the broker keeps messages for a disconnected monitor [s], if its own limits allow."""

    ca_file: Path | None = None
    """Certificates (PEM) that sign the broker's certificate; by default those of the operating system."""

    certificate: Path | None = None
    """Certificate (PEM) of this client, if the broker requires one."""

    key: Path | None = None
    """Private key (PEM) of the certificate."""

    verify: bool = True
    """Whether the broker's certificate is checked; with ``false`` anyone on the route can read and change
    messages."""

    username: str = ""
    """User name; by default from the environment variable HYDROFDI_MQTT_USERNAME."""

    password_file: Path | None = None
    """File that contains only the password, readable only by its owner; by default the environment variable
    HYDROFDI_MQTT_PASSWORD."""

    windows: bool = False
    """Whether ``--events`` sends windows to a topic as well as events."""

    @model_validator(mode="after")
    def _has_both(self) -> Self:
        if (self.certificate is None) != (self.key is None):
            raise ValueError("'certificate' and 'key' belong together")
        return self
