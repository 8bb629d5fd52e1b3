"""The JSON Schema of experiment files."""

from __future__ import annotations

from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.request import parameter_names
from hydrofdi.indicators.labels import LABEL_PATTERN, TAKEN
from hydrofdi.settings.schema import described_schema


def experiment_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of an experiment file, field texts and units included."""
    schema = described_schema(ExperimentConfig, "hydrofdi experiment")
    names = {"enum": list(parameter_names())}
    sweep = schema["$defs"]["SweepConfig"]["properties"]
    sample = schema["$defs"]["SampleConfig"]["properties"]
    replicates = schema["$defs"]["ReplicatesConfig"]["properties"]
    for mapping in (
        schema["properties"]["baseline"],
        sweep["grid"],
        sweep["zip"],
        sample["over"],
        replicates["over"],
    ):
        mapping["propertyNames"] = names
        mapping.pop("default", None)
    chosen = schema["properties"]["indicators"]
    schema["properties"]["indicators"] = {
        "description": chosen["description"],
        "anyOf": [
            {"type": "string", "description": "'all', a name, or names with commas between them"},
            {"type": "array", "items": {"type": "string"}, "minItems": 1, "uniqueItems": True},
            {
                "type": "object",
                "minProperties": 1,
                "propertyNames": {"pattern": LABEL_PATTERN, "not": {"enum": sorted(TAKEN)}},
                "additionalProperties": {"type": ["object", "null"]},
            },
        ],
    }
    schema["properties"]["extends"] = {
        "description": "Experiment file, or files, whose keys this one overrides.",
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
    }
    return schema
