"""How brokers are spoken to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from hydrofdi.settings.quantities import SI, Section


class MqttConfig(Section):
    """Connections to brokers of MQTT 5. Messages are sent and read at quality of service 1."""

    client_id: str = Field(default="", max_length=128)
    """Name under which the broker keeps the messages of a source while it is away. Two clients of one name
    throw each other out. A digest of the name of the machine, the path of the detector and the
    topic where left out."""

    keepalive: Annotated[float, SI("s", least=5.0, most=3600.0)] = 30.0
    """A connection without an answer for about this time [s] is given up."""

    session_expiry: Annotated[float, SI("s", least=0.0, most=4.0e9)] = 604_800.0
    """How long the broker keeps the messages of a source that is away [s], if its own limits allow."""

    ca_file: Path | None = None
    """Certificates (PEM) that sign the broker's; those of the operating system where left out."""

    certificate: Path | None = None
    """Certificate (PEM) of this client, where the broker asks for one."""

    key: Path | None = None
    """Private key (PEM) of the certificate."""

    verify: bool = True
    """Whether the broker's certificate is checked; ``false`` lets anyone on the way read and change
    messages."""

    username: str = ""
    """Name of the user; else that of the environment variable HYDROFDI_MQTT_USERNAME."""

    password_file: Path | None = None
    """File that holds the password alone, readable by its owner only; else the environment variable
    HYDROFDI_MQTT_PASSWORD."""

    windows: bool = False
    """Whether ``--events`` sends windows to a topic beside events."""

    @model_validator(mode="after")
    def _has_both(self) -> Self:
        if (self.certificate is None) != (self.key is None):
            raise ValueError("'certificate' and 'key' belong together")
        return self
