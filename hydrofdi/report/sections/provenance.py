"""What the numbers were made from."""

from __future__ import annotations

import json
from typing import Any

from hydrofdi.config.request import parameter_names
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.seeds import seeds_of, shown_seeds
from hydrofdi.config.shown_values import shown_value
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.store import ExperimentData


def provenance_block(data: ExperimentData) -> Block:
    """The resolved configuration, without what is empty, and the library versions."""
    sheet = Sheet(
        "versions",
        "Versions",
        ("Library", "Version"),
        tuple((Cell(name), Cell(version)) for name, version in sorted(data.versions.items())),
        text_columns=(0, 1),
    )
    return Block(
        "provenance",
        "Configuration and provenance",
        (
            "An identical request gives identical runs, whatever the batch or worker count.",
            f"Seeds: {shown_seeds(seeds_of(data.experiment))}.",
        ),
        (_configuration_sheet(data), sheet),
        is_detail=True,
    )


def _configuration_sheet(data: ExperimentData) -> Sheet:
    """The configuration as it is written in the file: parameters of later versions are not in it."""
    configuration = without_contents(data.configuration or json.loads(data.experiment.model_dump_json()))
    rows = []
    for section, value in configuration.items():
        fields = value if isinstance(value, dict) else {"": value}
        for name, content in fields.items():
            if content not in (None, "", [], {}):
                parameter = name if "." in name else f"{section}.{name}"
                rows.append((Cell(_key(section, name)), Cell(_text(parameter, content))))
    return Sheet("configuration", "Configuration", ("Key", "Value"), tuple(rows), text_columns=(0, 1))


def _text(name: str, content: Any) -> str:
    """A value with its unit where it is that of a parameter; mappings and lists part by part."""
    if name in parameter_names():
        values = content if isinstance(content, list) else [content]
        return ", ".join(shown_value(name, value) for value in values)
    if isinstance(content, dict):
        return "; ".join(f"{key}: {_text(key, value)}" for key, value in content.items())
    return content if isinstance(content, str) else json.dumps(content)


def _key(section: str, name: str) -> str:
    if not name:
        return section
    return f"{section}: {name}" if "." in name else f"{section}.{name}"
