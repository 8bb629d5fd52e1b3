"""The JSON Schema of descriptions of measured files."""

from __future__ import annotations

from typing import Any

from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.settings.schema import described_schema


def measured_schema() -> dict[str, Any]:
    """The JSON Schema of a description; channels and the format may also be plain texts."""
    schema = described_schema(MeasuredConfig, "hydrofdi measured files")
    properties, text = schema["properties"], {"type": "string"}
    channel = properties["channels"]["additionalProperties"]
    properties["channels"]["additionalProperties"] = {"anyOf": [channel, text, {"type": "integer"}]}
    reference = {"$ref": "#/$defs/FormatConfig"}
    properties["format"] = {
        "anyOf": [reference, text],
        "description": schema["$defs"]["FormatConfig"]["description"],
    }
    return schema
