"""Configuration, seeds and versions behind the numbers."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.plausibility import seeds_of, shown_seeds
from hydrofdi.config.request import parameter_names
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.shown_values import shown_value
from hydrofdi.report.table import Block, Table
from hydrofdi.store.experiment_data import ExperimentData

_MACHINE = {
    "actuator.piston_area": "Piston area",
    "actuator.piston_area_2": "Piston area of chamber 2",
    "actuator.chamber_volume": "Volume of a chamber",
    "actuator.chamber_volume_2": "Volume of chamber 2",
    "actuator.stroke": "Stroke",
    "actuator.inclination": "Inclination",
    "actuator.mass": "Moving mass",
    "supply.pressure": "Supply pressure",
    "fluid.bulk_modulus": "Effective bulk modulus (EBM)",
    "friction.viscous": "Viscous friction",
    "input.shape": "Drive",
    "record.duration": "Record",
    "record.sampling_frequency": "Sampling frequency",
}
"""What says which machine an experiment is about, and how people call it; left out if it is not stated."""


def machine_block(data: ExperimentData) -> Block:
    """The nominal machine and its records, as on a data sheet."""
    stated = {name: value for name in _MACHINE if (value := data.experiment.value(name))}
    names, values = [_MACHINE[name] for name in stated], [*map(shown_value, stated, stated.values())]
    table = Table.of({"Machine": names, "Nominal": values, "Key": [*stated]}, key="machine")
    return Block("machine", "The machine", (), (table,))


def provenance_block(data: ExperimentData) -> Block:
    """What the experiment states, the library versions, and the settings at their defaults."""
    libraries = sorted(data.versions)
    versions = {"Library": libraries, "Version": [data.versions[name] for name in libraries]}
    stated, others = _settings(data)
    return Block(
        "provenance",
        "Configuration and provenance",
        (
            "An identical request gives identical runs, whatever the batch or worker count.",
            f"Seeds: {shown_seeds(seeds_of(data.experiment))}.",
        ),
        (
            _settings_table("configuration", "What the experiment sets", stated),
            Table.of(versions, title="Versions", key="versions"),
            replace(_settings_table("defaults", "Settings at their default values", others), is_folded=True),
        ),
    )


def _settings(data: ExperimentData) -> tuple[dict[str, Any], dict[str, Any]]:
    """The settings that differ from their defaults, and the others; without what is empty.

    The configuration is as it is written in the file: parameters of later versions are not in it. Its values
    have the units that it states, which are left out.
    """
    usual = _flat(ExperimentConfig(name=data.experiment.name).model_dump(mode="json")) | {"name": None}
    configuration = data.configuration or data.experiment.model_dump(mode="json")
    found: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    for key, content in _flat(without_contents(configuration)).items():
        if content not in (None, "", [], {}):
            found[key in usual and usual[key] == content][key] = content
    return found


def _flat(configuration: dict[str, Any]) -> dict[str, Any]:
    """Section and field → what the field contains."""
    flat = {}
    for section, value in configuration.items():
        if section == "indicators" and isinstance(value, dict):
            value = {label: options or "default options" for label, options in value.items()}
        if not isinstance(value, dict):
            flat[section] = value
        elif section != "units":
            for name, content in value.items():
                flat[f"{section}: {name}" if "." in name else f"{section}.{name}"] = content
    return flat


def _settings_table(key: str, title: str, settings: dict[str, Any]) -> Table:
    texts = [_text(name.rpartition(": ")[2], content) for name, content in settings.items()]
    return Table.of({"Key": [*settings], "Value": texts}, title=title, key=key)


def _text(name: str, content: Any) -> str:
    """A value with its unit where it is that of a parameter; mappings and lists part by part."""
    if name in parameter_names():
        values = content if isinstance(content, list) else [content]
        return ", ".join(shown_value(name, value) for value in values)
    if isinstance(content, dict):
        parts = {key: value for key, value in content.items() if value is not None}
        return "; ".join(f"{key}: {_text(key, value)}" for key, value in parts.items())
    if isinstance(content, list):
        return ", ".join(_text(name, value) for value in content)
    return content if isinstance(content, str) else json.dumps(content)
