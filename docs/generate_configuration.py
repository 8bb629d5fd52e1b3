"""Write pages and JSON Schemas from the models of all kinds of files.

::

    python docs/generate_configuration.py           write them (also: make docs)
    python docs/generate_configuration.py --check   fail if they are not what would be written (make check)
"""

from __future__ import annotations

import json
import math
import sys
import typing
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from generators.writing import table
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.loading import PARAMETER_MAPPINGS
from hydrofdi.config.names import SYMBOLS, full_names
from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.config.study.study import WatchedChart
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.detectors.charts import ChartOptions
from hydrofdi.detectors.registry import chart_kind, chart_names, score_kind, score_names
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.indicators.selection import LABEL_PATTERN, TAKEN
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.fleet_configuration import FleetConfig
from hydrofdi.records.measured.description.sections import MeasuredConfig
from hydrofdi.settings.quantities import SI, Section, field_texts
from hydrofdi.settings.readable import readable_unit, typeset
from hydrofdi.units import convert, parse_quantity

DOCS, CONFIGS = Path(__file__).parent, Path(__file__).parent.parent / "configs"
PACKAGE = Path(__file__).parent.parent / "hydrofdi"

INTRODUCTION = """\
# Configuration

<!-- written by docs/generate_configuration.py from hydrofdi/config; change the docstrings there -->

An experiment file is YAML. Keys that it omits have the default below; an empty file is refused. A
quantity is a number in SI or a string with a unit, such as `551 MPa`, `0.12 L/min` or `22 µm/V`
([units](how-to/units.md)). Wrong units, unknown keys, duplicate keys and numbers out of range are
refused, all at once, with `file:line` and dotted key. `extends: other.yaml` starts from another file.

A parameter is named alike everywhere, here, in `sweep`, `baseline`, `--set`, `--grid` and Python: by its
key with a dot (`fluid.bulk_modulus`), by the key alone if no other section has it (`bulk_modulus`), or by
its [symbol](glossary.md#symbols) (`EBM`). The full name is what is stored.
[configs/table3.yaml](../configs/table3.yaml) is a complete example. `hydrofdi init` writes a file for
your own actuator.

Symbols and equation numbers are those of Maddahi et al., CDSR 2015, paper 181. Our copy of the paper
lacks all digits 0 and 2, so the nominal values are one possible scenario. "Legible as" quotes the
remaining digits, and the text says how reliable a value is.
"""

MEASURED_INTRODUCTION = """\
# Descriptions of measured files

<!-- written by docs/generate_configuration.py from hydrofdi/records/measured; change the docstrings there -->

This page lists every key of the YAML that [measured records](measured.md) explains. A quantity is a number in
SI or a string with a unit, such as `1 kHz` or `20 ms`. Unknown keys, duplicate keys and wrong units are
refused, all at once, with `file:line`.
"""

MONITOR_INTRODUCTION = """\
# Configuration of a monitor

<!-- written by docs/generate_configuration.py from hydrofdi/monitor; change the docstrings there -->

This page lists every key of the YAML that `hydrofdi monitor --config` reads
([monitoring](monitoring.md)). A quantity is a number in SI or a string with a unit, such as `1 kHz` or
`20 ms`. Unknown keys, duplicate keys and wrong units are refused, all at once, with `file:line`. Paths
are relative to the folder of the file.
The file may also be the [description of measured files](measured-configuration.md) that a detector was
trained on: what names and labels files is left out here, and `zone`, `mqtt` and `opcua` are left out there.
What would change the samples (`trim`, `cycles`, `segment`, `normalize`, `resample`) is refused.
"""


FLEET_INTRODUCTION = """

## A fleet

A fleet file, `hydrofdi monitor fleet.yaml`, has these keys besides all of the above ([fleets](fleets.md)).
"""


def fleet_section() -> str:
    """The keys of a fleet file that are not those of a monitor."""
    own = {
        name: each
        for name, each in FleetConfig.model_fields.items()
        if name not in MonitorConfig.model_fields
    }
    return "\n".join([FLEET_INTRODUCTION, _table(own, field_texts(FleetConfig))])


def page(config: type[BaseModel], introduction: str) -> str:
    """The text of a page on every key of a file."""
    models = [(name, info) for name, info in config.model_fields.items() if _model(info) is not None]
    plain = {name: info for name, info in config.model_fields.items() if _model(info) is None}
    texts = field_texts(config)
    parts = [introduction, *(["## Top level\n", _table(plain, texts)] if plain else [])]
    names: dict[type[BaseModel], list[str]] = {}
    for name, info in models:
        names.setdefault(_model(info), []).append(name)
    for model, same in names.items():
        is_mapping = typing.get_origin(config.model_fields[same[0]].annotation) is dict
        parts += _section(same, model, texts.get(same[0]) if is_mapping else None)
    return "\n".join(parts)


def _section(names: list[str], model: type[BaseModel], lead: str | None = None) -> Iterator[str]:
    fields = model.model_fields
    yield "\n## " + ", ".join(f"`{name}`" for name in names) + "\n"
    yield f"{_sentence(lead)} {_sentence(model.__doc__)}".strip() + "\n"
    yield _table(fields, field_texts(model))
    for field, info in fields.items():
        inner = _model(info)
        if inner not in (None, model):
            yield from _section([f"{name}.{field}" for name in names], inner)
    if model is WatchedChart:
        yield from _rules()


def _rules() -> Iterator[str]:
    """The options of every chart, those that all share first."""
    yield "\nOptions of every rule; a study takes `direction` from the indicator unless it is stated:\n"
    yield _table(ChartOptions.model_fields, field_texts(ChartOptions))
    for name in chart_names():
        kind = chart_kind(name)
        own = {
            key: info
            for key, info in kind.Options.model_fields.items()
            if key not in ChartOptions.model_fields
        }
        yield f"\n`{name}`: {kind.summary} {kind.caution}\n"
        if own:
            yield _table(own, field_texts(kind.Options))


def _table(fields: dict[str, FieldInfo], texts: dict[str, str]) -> str:
    lines = ["| key | default | allowed | meaning |", "|---|---|---|---|"]
    for name, info in fields.items():
        cells = f"`{name}`", _default(info), _allowed(info), _sentence(texts.get(name))
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def _sentence(text: str | None) -> str:
    return " ".join((text or "").replace("``", "`").split())


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "(required)"
    value, quantity = info.get_default(call_default_factory=True), _metadata(info, SI)
    if value is None or isinstance(value, BaseModel) or value in ({}, [], (), ""):
        return "–"
    if isinstance(value, dict):
        return ", ".join(
            f"`{key}: {_shown(item, parameter_unit(key) or '1')}`" if "." in key else f"`{key}`"
            for key, item in value.items()
        )
    if isinstance(value, tuple | list):
        return ", ".join(f"`{item if quantity is None else _shown(item, quantity.unit)}`" for item in value)
    return f"`{value if quantity is None else _shown(float(value), quantity.unit)}`"


def _shown(value: float, unit: str) -> str:
    if unit in ("1", "%"):
        return f"{value:g} {unit}".removesuffix(" 1")
    readable = readable_unit(unit, abs(value))
    text = f"{value if readable == unit else convert(value, readable):g} {typeset(readable)}"
    assert math.isclose(parse_quantity(text, unit), value, rel_tol=1e-12), text
    return text


def _allowed(info: FieldInfo) -> str:
    if (quantity := _metadata(info, SI)) is not None:
        limits = [("> ", quantity.above), ("≥ ", quantity.least)]
        numbers = " ".join(f"{sign}{limit:g}" for sign, limit in limits if limit is not None) or "any"
        return numbers if quantity.unit == "1" else f"{numbers} {typeset(quantity.unit)}"
    if choices := _literals(info.annotation):
        return ", ".join(f"`{choice}`" for choice in choices)
    inner = _metadata(info, FieldInfo)
    metadata = info.metadata if inner is None else inner.metadata
    limits = [f"≥ {part.ge}" for part in metadata if getattr(part, "ge", None) is not None]
    limits += [f"≤ {part.le}" for part in metadata if getattr(part, "le", None) is not None]
    return ", ".join([_kind(info), *limits])


def _kind(info: FieldInfo) -> str:
    kinds: dict[Any, str] = {
        **{int: "integer", bool: "`true`, `false`", dict: "mapping"},
        **dict.fromkeys((list, tuple), "list"),
    }
    annotated = [part for part in typing.get_args(info.annotation) if hasattr(part, "__metadata__")]
    annotation = annotated[0].__origin__ if annotated else _without_none(info.annotation)
    kind = typing.get_origin(annotation) or annotation
    return "section" if _model(info) and kind not in (list, tuple) else kinds.get(kind, "text")


def _literals(annotation: Any) -> list[Any]:
    annotation = _without_none(annotation)
    return list(typing.get_args(annotation)) if typing.get_origin(annotation) is typing.Literal else []


def _without_none(annotation: Any) -> Any:
    """``X`` of ``X | None``; everything else as it is."""
    parts = [part for part in typing.get_args(annotation) if part is not type(None)]
    return parts[0] if len(parts) == 1 and type(None) in typing.get_args(annotation) else annotation


def _metadata(info: FieldInfo, kind: type) -> Any:
    nested = [
        part for union in typing.get_args(info.annotation) for part in getattr(union, "__metadata__", ())
    ]
    return next((part for part in [*info.metadata, *nested] if isinstance(part, kind)), None)


def _model(info: FieldInfo) -> Any:
    candidates = [info.annotation, *typing.get_args(info.annotation)]
    return next((part for part in candidates if isinstance(part, type) and issubclass(part, BaseModel)), None)


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
    ],
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
        options = kind.Options.model_json_schema()
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
    note = "<!-- symbols: written by docs/generate_configuration.py from hydrofdi/config/names.py -->"
    return f"{own}{note}\n\n{table(('parameter', 'symbols', 'SI unit'), rows)}\n"


if __name__ == "__main__":
    texts = {
        DOCS / "glossary.md": _glossary(),
        PACKAGE / "api" / "settings.pyi": _typed_settings(),
        DOCS / "configuration.md": page(ExperimentConfig, INTRODUCTION),
        DOCS / "measured-configuration.md": page(MeasuredConfig, MEASURED_INTRODUCTION),
        DOCS / "monitoring-configuration.md": page(MonitorConfig, MONITOR_INTRODUCTION) + fleet_section(),
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
