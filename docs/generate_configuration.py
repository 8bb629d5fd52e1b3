"""Write what the repository keeps of the models of YAML files: schemas, table of symbols, typed settings.

::

    python docs/generate_configuration.py           write them (also: make docs)
    python docs/generate_configuration.py --check   fail if they are not what would be written (make check)
"""

from __future__ import annotations

import json
import sys
import typing
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from generators.writing import table
from pydantic import BaseModel

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.loading import PARAMETER_MAPPINGS
from hydrofdi.config.request import SYMBOLS, full_names, parameter_names, parameter_unit
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.rules import chart_kind, chart_names, score_kind, score_names
from hydrofdi.indicators.registry import LABEL_PATTERN, TAKEN
from hydrofdi.monitor.configuration import FleetConfig, MonitorConfig
from hydrofdi.records.description import MeasuredConfig
from hydrofdi.settings.messages import typeset
from hydrofdi.settings.quantities import Section, field_texts

DOCS, CONFIGS = Path(__file__).parent, Path(__file__).parent.parent / "configs"
PACKAGE = Path(__file__).parent.parent / "hydrofdi"


def _schema(model: type[BaseModel], title: str) -> str:
    return json.dumps(_described_schema(model, title), indent=2) + "\n"


def _described_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a file that contains a section; field texts and units included."""
    schema = model.model_json_schema()
    sections = {section.__name__: section for section in _sections(model)}
    for name, definition in [(model.__name__, schema), *schema["$defs"].items()]:
        if name not in sections:
            continue
        for field, text in field_texts(sections[name]).items():
            key = sections[name].model_fields[field].alias or field
            described = definition["properties"][key] | {"description": text}
            definition["properties"][key] = dict(sorted(described.items()))
        if sections[name].short_forms:
            schema["$defs"][name] = {"anyOf": [definition, *sections[name].short_forms]}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _sections(annotation: Any, found: set[type[Section]] | None = None) -> set[type[Section]]:
    """All sections in an annotation, and in the fields of sections."""
    found = set() if found is None else found
    inner = typing.get_args(annotation)
    if isinstance(annotation, type) and issubclass(annotation, Section) and annotation not in found:
        found.add(annotation)
        inner = tuple(info.annotation for info in annotation.model_fields.values())
    for part in inner:
        _sections(part, found)
    return found


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
    ]
}
"""Forms in which indicators are chosen."""


def _experiment_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of an experiment file, field texts and units included."""
    schema = _described_schema(ExperimentConfig, "hydrofdi experiment")
    aliases = {name: full for name, full in full_names().items() if "." not in name and "__" not in name}
    schema["$defs"]["ParameterName"] = {"enum": [*parameter_names(), *aliases]}
    names = {"$ref": "#/$defs/ParameterName"}
    stated = {name: {"description": f"`{full}`"} for name, full in aliases.items()}
    schema["properties"] = stated | {"grid": {}, "zip": {}, "sample": {}, "where": {}} | schema["properties"]
    for section in (schema, *schema["$defs"].values()):
        for mapping in (section.get("properties", {}).get(name) for name in PARAMETER_MAPPINGS):
            if mapping is not None:
                mapping["propertyNames"] = names
                mapping.pop("default", None)
    _allow_short_faults(schema["$defs"]["FaultsConfig"])
    _allow_short_options(schema["$defs"], "ScoreConfig", map(score_kind, score_names()))
    _allow_short_options(schema["$defs"], "WatchedChart", map(chart_kind, chart_names()))
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
    over |= {"minProperties": 1, "maxProperties": 1}


def _allow_short_options(definitions: dict[str, Any], section: str, kinds: Iterable[Any]) -> None:
    """Let the options of kinds stand in addition to the other keys of a section."""
    for kind in kinds:
        options = kind.model_json_schema()
        definitions[section]["properties"] |= options.get("properties", {})
        definitions |= options.get("$defs", {})


def _typed_settings() -> str:
    """The keywords that name parameters, for editors: those of `hydrofdi.simulate`."""
    keys = {name: full for name, full in full_names().items() if name.isidentifier()}
    known = {full for name, full in keys.items() if "__" not in name}
    keys = {name: full for name, full in keys.items() if "__" not in name or full not in known}
    typed = {
        name: f"{name}: {'float | str' if (unit := parameter_unit(full)) else 'Any'}  # {full}"
        + (f" [{typeset(unit)}]" if unit and unit != "1" else "")
        for name, full in keys.items()
    }
    others = {name: f"{name}: Any" for name in (*ExperimentConfig.model_fields, *SweepConfig.model_fields)}
    lines = "\n    ".join((typed | others).values())
    return (
        "# written by docs/generate_configuration.py\n\nfrom typing import Any, TypedDict\n\n"
        f"class Settings(TypedDict, total=False):\n    {lines}\n"
    )


def _glossary() -> str:
    """The glossary with its table of symbols, which is its end."""
    rows = [
        (f"`{name}`", ", ".join(f"`{symbol}`" for symbol in symbols), typeset(parameter_unit(name) or ""))
        for name, symbols in SYMBOLS.items()
    ]
    own = (DOCS / "glossary.md").read_text(encoding="utf-8").partition("<!-- symbols")[0]
    note = "<!-- symbols: written by docs/generate_configuration.py from hydrofdi/config -->"
    return f"{own}{note}\n\n{table(('parameter', 'symbols', 'SI unit'), rows)}\n"


if __name__ == "__main__":
    texts = {
        DOCS / "glossary.md": _glossary(),
        PACKAGE / "api" / "settings.pyi": _typed_settings(),
        CONFIGS / "schema.json": json.dumps(_experiment_schema(), indent=2) + "\n",
        CONFIGS / "measured-schema.json": _schema(MeasuredConfig, "hydrofdi measured files"),
        CONFIGS / "monitor-schema.json": _schema(MonitorConfig, "hydrofdi monitor"),
        CONFIGS / "fleet-schema.json": _schema(FleetConfig, "hydrofdi fleet"),
        CONFIGS / "detector-schema.json": _schema(DetectorFile, "hydrofdi detector"),
    }
    for file, text in texts.items():
        if "--check" not in sys.argv[1:]:
            file.write_text(text, encoding="utf-8")
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            sys.exit(f"{file.name} is not up to date; run 'make docs'")
