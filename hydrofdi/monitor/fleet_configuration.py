"""Settings of a fleet: its machines, their detectors, and where its state and its lines go."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Self
from zlib import crc32

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, MonitorConfig, is_mqtt, read_config, topic_address
from hydrofdi.records.description import one_or_more
from hydrofdi.settings.quantities import SI

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

    events: Annotated[tuple[str, ...], one_or_more(str)] = ()
    """Addresses to which events are sent: ``mqtt(s)://HOST/TOPIC``."""

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
        found = _PARTITION.fullmatch(given)
        if given and (found is None or int(found[1]) > int(found[2])):
            raise ValueError(f"{given!r} is no partition; write '1/3' to '3/3' for three processes")
        return given

    @field_validator("machines", "events")
    @classmethod
    def _are_addresses(cls, given: tuple[str, ...], about: ValidationInfo) -> tuple[str, ...]:
        for text in given:
            if about.field_name == "events":
                topic_address(text)
            else:
                Pattern.parse(text, Path())
        return given

    @model_validator(mode="after")
    def _reads_no_own_events(self) -> Self:
        for text in self.events:
            topic = Address.parse(text).path
            for pattern in (Pattern.parse(each, Path()) for each in self.machines if is_mqtt(each)):
                if pattern.name_in(topic) or pattern.name_in(f"{topic}/status"):
                    raise ValueError(
                        f"'events' {text} is also read, as that of a machine; choose another topic"
                    )
        return self

    def owns(self, name: str) -> bool:
        """Whether a machine belongs to this process."""
        part, _, n_part = self.partition.partition("/")
        return not part or crc32(name.encode()) % int(n_part) == int(part) - 1

    def detector_of(self, name: str) -> Path | None:
        """The file of the detector of a machine; None without a pattern that matches."""
        return next((path for each, path in self.detectors.items() if fnmatchcase(name, each)), None)


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
        before, found, after = self.text.partition(wildcard)
        if not found:
            own = place if self.address else Path(place).stem
            return own if place == self.text else None
        name = place[len(before) : len(place) - len(after)]
        fits = place.startswith(before) and place.endswith(after) and len(place) > len(before) + len(after)
        return name if fits and "/" not in name else None


def load_fleet_config(path: Path, **stated: Any) -> FleetConfig:
    """The configuration in a YAML file, with paths relative to its folder; keys `stated` replace its own."""
    config = read_config(FleetConfig, path, "a configuration of a fleet", **stated)
    folder = path.parent
    files = {key: folder / file for key, file in config if isinstance(file, Path)}
    detectors = {pattern: folder / file for pattern, file in config.detectors.items()}
    return config.model_copy(update={**files, "detectors": detectors})
