"""Settings of a monitor in addition to its detector and its source: a YAML file."""

from __future__ import annotations

from datetime import tzinfo
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import Field, field_validator

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.records.channels import Channel
from hydrofdi.records.dates import time_zone
from hydrofdi.records.measured.description.checks import channel_mistakes
from hydrofdi.records.measured.description.sections import ChannelConfig, FormatConfig, TimeConfig
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.settings.validation import read_yaml, validated

Placed = TypeVar("Placed", bound=Section)


class LimitsConfig(Section):
    """Limits of a stream."""

    payload: Annotated[int, Field(ge=1024, le=2**28)] = 2**20
    """Largest message or line of text [bytes]; a longer one is counted as malformed and skipped."""


class MonitorConfig(Section):
    """Settings of a monitor, apart from its detector and its source."""

    channels: dict[Channel, ChannelConfig] = Field(default_factory=dict)
    """Channel, by name or symbol such as ``P1`` → column of a text, key of a JSON object, or node of an OPC
    UA server. Text and JSON need none if their names and units are self-explanatory."""

    time: TimeConfig | None = None
    """Column or key of sampling instants; by default recognised by its name."""

    sampling_frequency: Annotated[float, SI("Hz", above=0.0)] | None = None
    """Sampling frequency of a text without time; its samples are counted."""

    zone: str = ""
    """Time zone of dates that state none, such as ``Europe/Berlin``, ``UTC`` or ``+01:00``. At the end of
    summer time an hour repeats; zones without summer time avoid that."""

    format: FormatConfig = FormatConfig()
    """Format of a text, as of measured files: ``delimiter``, ``decimal``, ``comment``, ``missing`` and
    ``encoding``. The other keys do not apply to a stream."""

    mqtt: MqttConfig = MqttConfig()

    opcua: OpcUaConfig = OpcUaConfig()

    limits: LimitsConfig = LimitsConfig()

    @field_validator("zone")
    @classmethod
    def _is_a_zone(cls, given: str) -> str:
        if given:
            time_zone(given)
        return given

    @field_validator("format")
    @classmethod
    def _is_of_a_stream(cls, given: FormatConfig) -> FormatConfig:
        if stated := sorted(given.model_fields_set & {"kind", "skip", "header", "units_row"}):
            raise ValueError(f"{stated[0]!r} does not apply to a stream")
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


def load_monitor_config(path: Path | None) -> MonitorConfig:
    """The configuration in a YAML file; the default without one. Paths in it are relative to its folder.

    Raises
    ------
    ConfigError
        The file is wrong; all mistakes are listed with their lines.
    """
    if path is None:
        return MonitorConfig()
    source = read_yaml(path, "a configuration of a monitor")
    source.data = source.data or {}
    config = validated(MonitorConfig, source)
    if mistakes := list(channel_mistakes(config.channels, source)):
        raise ConfigError(mistakes)
    return _placed(config, path.parent)


def _placed(section: Placed, folder: Path) -> Placed:
    """A section with its paths below a folder."""
    found = {name: getattr(section, name) for name in type(section).model_fields}
    paths = {name: folder / value for name, value in found.items() if isinstance(value, Path)}
    sections = {name: _placed(value, folder) for name, value in found.items() if isinstance(value, Section)}
    return section.model_copy(update=paths | sections)
