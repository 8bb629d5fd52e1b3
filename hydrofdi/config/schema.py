"""The JSON Schema of experiment files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.loading import PARAMETER_MAPPINGS
from hydrofdi.config.request import parameter_names
from hydrofdi.detectors.registry import chart_kind, chart_names, score_kind, score_names
from hydrofdi.indicators.selection import LABEL_PATTERN, TAKEN
from hydrofdi.settings.quantities import described_schema

_CHOICE: dict[str, Any] = {
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
"""Forms in which indicators are chosen."""


def experiment_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of an experiment file, field texts and units included."""
    schema = described_schema(ExperimentConfig, "hydrofdi experiment")
    names = {"enum": list(parameter_names())}
    for section in (schema, *schema["$defs"].values()):
        for mapping in (section.get("properties", {}).get(name) for name in PARAMETER_MAPPINGS):
            if mapping is not None:
                mapping["propertyNames"] = names
                mapping.pop("default", None)
    _allow_short_faults(schema["$defs"]["FaultsConfig"])
    _allow_short_options(schema["$defs"], "ScoreConfig", map(score_kind, score_names()))
    _allow_short_options(schema["$defs"], "ChartConfig", map(chart_kind, chart_names()))
    times = schema["$defs"]["OnlineConfig"]["properties"]["false_alarm_every"]
    times["anyOf"] = [times["items"], {key: times.pop(key) for key in ("type", "items", "minItems")}]
    for properties in (schema["properties"], schema["$defs"]["DetectionConfig"]["properties"]):
        properties["indicators"] = {"description": properties["indicators"]["description"], **_CHOICE}
    schema["properties"]["extends"] = {
        "description": "Experiment file, or files, whose keys this one overrides.",
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
    }
    return schema


def _allow_short_faults(faults: dict[str, Any]) -> None:
    """Let the parameter of faults stand beside their counts."""
    over = faults["properties"]["over"]
    axis = over["additionalProperties"]
    over["propertyNames"] = {"enum": list(INTERNAL_LEAKAGE_FORMS)}
    faults["properties"] |= dict.fromkeys(INTERNAL_LEAKAGE_FORMS, axis)
    faults["required"].remove("over")


def _allow_short_options(definitions: dict[str, Any], section: str, kinds: Iterable[Any]) -> None:
    """Let the options of kinds stand in addition to the other keys of a section."""
    for kind in kinds:
        options = kind.Options.model_json_schema()
        definitions[section]["properties"] |= options.get("properties", {})
        definitions |= options.get("$defs", {})
