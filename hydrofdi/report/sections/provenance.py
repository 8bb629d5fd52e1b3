"""What the numbers were made from."""

from __future__ import annotations

import json

from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.seeds import seeds_of, shown_seeds
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.store import ExperimentData


def provenance_block(data: ExperimentData) -> Block:
    """The resolved configuration in SI, without what is empty, and the library versions."""
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
            "Values are in SI. An identical request gives identical runs, whatever the batch or worker"
            " count.",
            f"Seeds: {shown_seeds(seeds_of(data.experiment))}.",
        ),
        (_configuration_sheet(data), sheet),
    )


def _configuration_sheet(data: ExperimentData) -> Sheet:
    """The configuration as it is written in the file: parameters of later versions are not in it."""
    configuration = without_contents(data.configuration or json.loads(data.experiment.model_dump_json()))
    rows = []
    for section, value in configuration.items():
        fields = value if isinstance(value, dict) else {"": value}
        for name, content in fields.items():
            if content not in (None, "", [], {}):
                text = content if isinstance(content, str) else json.dumps(content)
                rows.append((Cell(_key(section, name)), Cell(text)))
    return Sheet("configuration", "Configuration", ("Key", "Value"), tuple(rows), text_columns=(0, 1))


def _key(section: str, name: str) -> str:
    if not name:
        return section
    return f"{section}: {name}" if "." in name else f"{section}.{name}"
