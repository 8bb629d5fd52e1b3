"""Settings of a monitor in addition to its detector and its source: YAML files of a machine or a fleet."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import tzinfo
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar
from urllib.parse import unquote, urlsplit
from zlib import crc32

from pydantic import BeforeValidator, Field, field_validator, model_validator

from hydrofdi.errors import ConfigError
from hydrofdi.records.description import FormatConfig, SamplesConfig, channel_mistakes, one_or_more
from hydrofdi.records.times import time_zone
from hydrofdi.settings.files import read_yaml, validated
from hydrofdi.settings.quantities import SI, Section

PORTS = {"mqtt": 1883, "mqtts": 8883, "opc.tcp": 4840}
"""Schemes of addresses → their usual ports."""


def is_mqtt(text: str) -> bool:
    """Whether a text is meant as an address of MQTT."""
    return text.lower().startswith(("mqtt://", "mqtts://"))


@dataclass(frozen=True)
class Address:
    """A topic of an MQTT broker (``mqtt``, encrypted ``mqtts``), or an OPC UA server (``opc.tcp``)."""

    scheme: str
    host: str
    port: int
    path: str

    @classmethod
    def parse(cls, text: str, *, may_be_filter: bool = False) -> Self:
        """The address in a text such as ``mqtts://broker.example/press/samples``; MQTT is on this machine by
        default. The filter of a fleet may contain ``+``.
        """
        scheme, _, rest = text.partition("://")
        scheme, (server, _, path) = scheme.lower(), rest.partition("/")
        if "@" in rest:
            raise ConfigError(
                f"{scheme}://…: all users of the machine can see credentials in an address; use"
                " 'password_file', or HYDROFDI_MQTT_USERNAME, HYDROFDI_OPCUA_USERNAME and …_PASSWORD"
                " (in a topic, write %40)"
            )
        is_topic = scheme != "opc.tcp"
        path = unquote(path) if is_topic else path
        try:
            parts = urlsplit(f"//{server}")
            host, port = parts.hostname or ("localhost" if is_topic else ""), parts.port or PORTS.get(scheme)
            host.encode("idna")
        except ValueError:
            host, port = "", None
        wrong = set(path) & set(("#\0" if may_be_filter else "+#\0") if is_topic else "?#")
        if not host or port is None or wrong or (is_topic and not path):
            raise ConfigError(
                f"{text}: expected mqtt://HOST/TOPIC or mqtts://HOST/TOPIC, one topic without '+' and '#', or"
                " opc.tcp://HOST:PORT/PATH"
            )
        return cls(scheme, host, port, path)

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}/{self.path}"


class MqttConfig(Section):
    """Connections to MQTT 5 brokers. Messages are read at quality of service 1."""

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

    @model_validator(mode="after")
    def _has_both(self) -> Self:
        if (self.certificate is None) != (self.key is None):
            raise ValueError("'certificate' and 'key' belong together")
        return self


class OpcUaConfig(Section):
    """An OPC UA server: its security and its sampling."""

    publishing_interval: Annotated[float, SI("s", least=0.01, most=60.0)] = 0.5
    """Interval at which the server sends its samples [s]."""

    queue: Annotated[float, SI("s", above=0.0, most=3600.0)] = 60.0
    """Length of the queue of samples waiting for the monitor [s]; beyond it, the server has to wait."""

    security: Literal["none", "Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"] = "none"
    """Policy for signing and encryption. ``none``: anyone on the network can read and change samples."""

    certificate: Path | None = None
    """Certificate of this monitor, PEM or DER; the server must trust it."""

    key: Path | None = None
    """Private key of the certificate, PEM or DER, without a passphrase."""

    server_certificate: Path | None = None
    """Certificate of the server, PEM or DER; a server with another certificate is refused."""

    username: str = ""
    """User name; by default from the environment variable HYDROFDI_OPCUA_USERNAME. Anonymous if neither is
    set."""

    password_file: Path | None = None
    """File that contains only the password, readable only by its owner; by default the environment variable
    HYDROFDI_OPCUA_PASSWORD."""

    @model_validator(mode="after")
    def _whole_security(self) -> Self:
        files = {name: getattr(self, name) for name in ("certificate", "key", "server_certificate")}
        given = [name for name, path in files.items() if path is not None]
        missing = [name for name, path in files.items() if path is None]
        if self.security != "none" and missing:
            raise ValueError(f"security {self.security} also needs {', '.join(missing)}")
        if self.security == "none" and given:
            raise ValueError(f"{given[0]} needs a policy; write 'security: Basic256Sha256'")
        return self


class MonitorConfig(SamplesConfig):
    """A description, as of measured files, and connections. What concerns files and labels is left out."""

    zone: str = ""
    """Time zone of dates that state none, such as ``Europe/Berlin``, ``UTC`` or ``+01:00``. At the end of
    summer time an hour repeats; zones without summer time avoid that."""

    mqtt: MqttConfig = MqttConfig()

    opcua: OpcUaConfig = OpcUaConfig()

    @field_validator("zone")
    @classmethod
    def _is_a_zone(cls, given: str) -> str:
        if given:
            time_zone(given)
        return given

    @field_validator("format")
    @classmethod
    def _is_of_a_stream(cls, given: FormatConfig) -> FormatConfig:
        if given.kind not in (None, "text"):
            raise ValueError(f"{given.kind!r} is no kind of a stream, which is text")
        try:
            ends = "\n".encode(given.encoding)
        except LookupError:
            ends = b""
        if ends != b"\n":
            raise ValueError(f"{given.encoding!r} is no encoding of streams; for example utf-8 or cp1252")
        return given

    @property
    def time_zone(self) -> tzinfo | None:
        """The zone; None if it is not stated."""
        return time_zone(self.zone) if self.zone else None


_OF_RECORDS = {
    "files", "path", "group", "label", "healthy", "severity", "drive_period",
    "sampling_frequency_is",
}  # fmt: skip
"""Keys of a description that name and label records of files."""


Config = TypeVar("Config", bound=MonitorConfig)


def load_monitor_config(path: Path | None) -> MonitorConfig:
    """The configuration in a YAML file; the default without one. Paths in it are relative to its folder."""
    kind = "a configuration of a monitor"
    return MonitorConfig() if path is None else _read_config(MonitorConfig, path, kind)


def _read_config(model: type[Config], path: Path, kind: str, **stated: Any) -> Config:
    """The configuration in a YAML file; keys `stated` elsewhere replace its own."""
    source = read_yaml(path, kind)
    keys = (source.data or {}) | stated
    source.data = {key: value for key, value in keys.items() if key not in _OF_RECORDS}
    config = validated(model, source)
    if mistakes := list(channel_mistakes(config.channels, source)):
        raise ConfigError(mistakes)
    return _placed(config, path.parent)


AnySection = TypeVar("AnySection", bound=Section)


def _placed(section: AnySection, folder: Path) -> AnySection:
    """A section with its paths in a folder."""
    placed: dict[str, Any] = {key: folder / value for key, value in section if isinstance(value, Path)}
    connections = ((key, value) for key, value in section if isinstance(value, MqttConfig | OpcUaConfig))
    placed |= {key: _placed(value, folder) for key, value in connections}
    return section.model_copy(update=placed)


_PARTITION = re.compile(r"([1-9]\d{0,3})/([1-9]\d{0,3})")
_ANY = "*"

_for_all = BeforeValidator(
    lambda given: {_ANY: given} if isinstance(given, str) else given,
    json_schema_input_type=str | dict[str, str],
)


class FleetConfig(MonitorConfig):
    """Machines that one process monitors, and the description of their samples, as of a monitor."""

    machines: Annotated[tuple[str, ...], one_or_more(str), Field(min_length=1)]
    """Sources: topics such as ``mqtt://HOST/plant/+/samples``, and text files such as ``presses/*.csv``. What
    ``+`` or ``*`` stands for is the name of a machine; without either, it is the topic, or the name of the
    file without its suffix. New topics and files are new machines."""

    detectors: Annotated[dict[str, Path], _for_all]
    """Pattern of names, such as ``press-*`` → file of the detector; the first that matches counts. A single
    file is that of all machines."""

    state: Path | None = None
    """File of the state of all machines, an SQLite database; without it, a restart begins anew."""

    log: Path | None = None
    """File to which every line is appended, once."""

    metrics: str = ""
    """Address at which metrics are served for Prometheus, ``HOST:PORT``."""

    interval: Annotated[float, SI("s", least=0.01, most=10.0)] = 0.25
    """Samples that arrive within this time are judged together [s]."""

    store_every: Annotated[float, SI("s", least=0.01, most=60.0)] = 0.5
    """Shortest time between two writings of state and log [s]."""

    idle: Annotated[float, SI("s", least=1.0, most=4.0e9)] = 3600.0
    """A machine whose topic is silent for this time [s] is released from memory; its stored state stays."""

    most_machines: int = Field(default=1000, ge=1)
    """More machines at a time are ignored, so that wrong topics cannot fill the memory."""

    partition: str = ""
    """``k/n``: the k-th of n processes, which share the machines by a checksum of their names."""

    @field_validator("partition")
    @classmethod
    def _is_a_partition(cls, given: str) -> str:
        parts = _PARTITION.fullmatch(given)
        if given and (parts is None or int(parts[1]) > int(parts[2])):
            raise ValueError(f"{given!r} is no partition; write '1/3' to '3/3' for three processes")
        return given

    @field_validator("machines")
    @classmethod
    def _are_patterns(cls, given: tuple[str, ...]) -> tuple[str, ...]:
        for text in given:
            Pattern.parse(text, Path())
        return given

    def owns(self, name: str) -> bool:
        """Whether a machine belongs to this process."""
        part, _, n_part = self.partition.partition("/")
        return not part or crc32(name.encode()) % int(n_part) == int(part) - 1

    def detector_of(self, name: str) -> Path | None:
        """The file of the detector of a machine; None without a pattern that matches."""
        return next((path for pattern, path in self.detectors.items() if fnmatchcase(name, pattern)), None)


@dataclass(frozen=True)
class Pattern:
    """A source of machines: topics of a broker, or files.

    Attributes
    ----------
    address : Address or None
        Broker and topic filter; None for files.
    text : str
        The topic filter, or the absolute path with its wildcard.
    """

    address: Address | None
    text: str

    @classmethod
    def parse(cls, text: str, folder: Path) -> Self:
        """The sources that a text means; paths are relative to a folder."""
        if is_mqtt(text):
            address = Address.parse(text, may_be_filter=True)
            levels = address.path.split("/")
            if levels[0] == "$share":
                raise ConfigError(
                    f"{text}: brokers deal the messages of one machine out to all members of a shared"
                    " subscription, which breaks its windows; use 'partition'"
                )
            if address.path.count("+") != levels.count("+") or levels.count("+") > 1:
                raise ConfigError(f"{text}: one level may be '+', the name of the machine")
            return cls(address, address.path)
        if "://" in text or text == "-":
            raise ConfigError(f"{text}: machines are topics, mqtt(s)://HOST/TOPIC, or files")
        if text.count(_ANY) > 1:
            raise ConfigError(f"{text}: one '*' stands for the name of the machine")
        return cls(None, str(folder.resolve() / text))

    def name_in(self, place: str) -> str | None:
        """The name of the machine at a topic or a path; None if it is none of these."""
        wildcard = "+" if self.address else _ANY
        before, has_name, after = self.text.partition(wildcard)
        if not has_name:
            own = place if self.address else Path(place).stem
            return own if place == self.text else None
        name = place[len(before) : len(place) - len(after)]
        fits = place.startswith(before) and place.endswith(after) and len(place) > len(before) + len(after)
        return name if fits and "/" not in name else None


def load_fleet_config(path: Path, **stated: Any) -> FleetConfig:
    """The configuration in a YAML file, with paths relative to its folder; keys `stated` replace its own."""
    config = _read_config(FleetConfig, path, "a configuration of a fleet", **stated)
    detectors = {pattern: path.parent / file for pattern, file in config.detectors.items()}
    return config.model_copy(update={"detectors": detectors})
