"""Addresses of topics: ``mqtt://host:port/topic``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self
from urllib.parse import unquote, urlsplit

from hydrofdi.errors import ConfigError

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
