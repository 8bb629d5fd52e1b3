"""The JSON Schema of experiment files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.parameters import parameter_names
from hydrofdi.settings.docstrings import field_texts
from hydrofdi.settings.quantities import Section


def experiment_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of an experiment file, field texts and units included."""
    schema = ExperimentConfig.model_json_schema()
    sections = {section.__name__: section for section in _sections(Section)}
    for name, definition in [(ExperimentConfig.__name__, schema), *schema["$defs"].items()]:
        for field, text in field_texts(sections[name]).items():
            described = definition["properties"][field] | {"description": text}
            definition["properties"][field] = dict(sorted(described.items()))
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
    schema["properties"]["extends"] = {
        "description": "Experiment file, or files, whose keys this one overrides.",
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "hydrofdi experiment",
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _sections(base: type[Section]) -> Iterator[type[Section]]:
    for section in base.__subclasses__():
        yield section
        yield from _sections(section)
