"""Settings of connections to MQTT brokers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from hydrofdi.settings.quantities import SI, Section


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
