"""Settings of a monitor in addition to its detector and its source: a YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import Field

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.monitor.sources.text.config import TextConfig
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.checks import channel_mistakes
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.settings.quantities import Section
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

    text: TextConfig = TextConfig()

    mqtt: MqttConfig = MqttConfig()

    opcua: OpcUaConfig = OpcUaConfig()

    limits: LimitsConfig = LimitsConfig()


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
