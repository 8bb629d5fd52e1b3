"""What a monitor is told beside its detector and its source: a YAML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.sources.opcua_configuration import OpcUaConfig
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.schema import described_schema
from hydrofdi.settings.validation import read_yaml, validated


class LimitsConfig(Section):
    """What is too much."""

    payload: Annotated[int, Field(ge=1024, le=2**30)] = 2**20
    """Bytes of a message, or of a line; longer ones are counted as malformed."""


class MonitorConfig(Section):
    """A monitor beside its detector and its source."""

    channels: dict[Channel, ChannelConfig] = Field(default_factory=dict)
    """Channel → column of a text, key of a JSON object, or node of an OPC UA server. Text and JSON need none
    where their names and units say enough."""

    mqtt: MqttConfig = MqttConfig()

    opcua: OpcUaConfig = OpcUaConfig()

    limits: LimitsConfig = LimitsConfig()


def load_monitor_config(path: Path | None) -> MonitorConfig:
    """The configuration in a YAML file; the default without one. Paths in it start at its folder.

    Raises
    ------
    ConfigError
        With every mistake in the file, and its line.
    """
    if path is None:
        return MonitorConfig()
    config = validated(MonitorConfig, read_yaml(path, "a configuration of a monitor"))
    return MonitorConfig.model_validate(_placed(config, path.parent))


def _placed(value: Any, folder: Path) -> Any:
    """Data of a section with its paths from a folder."""
    if isinstance(value, Section):
        return {name: _placed(getattr(value, name), folder) for name in value.model_fields_set}
    if isinstance(value, dict):
        return {name: _placed(inner, folder) for name, inner in value.items()}
    return folder / value if isinstance(value, Path) else value


def monitor_schema() -> dict[str, Any]:
    """The JSON Schema of a configuration; a text alone may stand for a channel."""
    schema = described_schema(MonitorConfig, "hydrofdi monitor")
    channels = schema["properties"]["channels"]
    column = {"anyOf": [channels["additionalProperties"], {"type": "string"}, {"type": "integer"}]}
    channels["additionalProperties"] = column
    return schema
