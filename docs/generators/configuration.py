"""The pages of every key of YAML files, from the models that read them."""

from __future__ import annotations

import math
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from generators.writing import table, write_page
from hydrofdi.config import ExperimentConfig
from hydrofdi.config.request import parameter_unit
from hydrofdi.config.study import WatchedChart
from hydrofdi.detectors.charts import Chart
from hydrofdi.detectors.rules import chart_kind, chart_names
from hydrofdi.monitor.configuration import FleetConfig, MonitorConfig
from hydrofdi.records.description import MeasuredConfig, SamplesConfig
from hydrofdi.settings.messages import convert, readable_unit, typeset
from hydrofdi.settings.quantities import SI, field_texts
from hydrofdi.units import parse_quantity

EXPERIMENT = """\
# Configuration

An experiment file is YAML. Keys that it omits have the default below; an empty file is refused. A
quantity is a number in SI or a string with a unit, such as `551 MPa`, `0.12 L/min` or `22 µm/V`
([units](../how-to/units.md)). Wrong units, unknown keys, duplicate keys and numbers out of range are
refused, all at once, with `file:line` and dotted key. `extends: other.yaml` starts from another file.

A parameter is named alike everywhere, here, in `sweep`, `baseline`, `--set`, `--grid` and Python: by its
key with a dot (`fluid.bulk_modulus`), by the key alone if no other section has it (`bulk_modulus`), or by
its [symbol](../glossary.md#symbols) (`EBM`). The full name is what is stored.
[configs/table3.yaml](configurations/table3.md) is a complete example. `hydrofdi init` writes a file for
your own actuator.

Symbols and equation numbers are those of Maddahi et al., CDSR 2015, paper 181. Our copy of the paper
lacks all digits 0 and 2, so the nominal values are one possible scenario. "Legible as" quotes the
remaining digits, and the text says how reliable a value is.

## Top level
"""

SAMPLES = """\
# Descriptions of samples

Every key of the YAML that describes [measured files](../measured.md), or the stream of `hydrofdi monitor
--config` ([monitoring](../monitoring.md)). A quantity is a number in SI or a string with a unit, such as
`1 kHz` or `20 ms`. Unknown keys, duplicate keys and wrong units are refused, all at once, with `file:line`.
Paths are relative to the folder of the file.

## Files and streams
"""

MEASURED = """
## Only files
"""

MONITOR = """
## Only streams

A monitor may also read the description of the files that its detector was trained on: what names and labels
files is ignored, as are `zone`, `mqtt` and `opcua` where files are read. What would change the samples
(`trim`, `cycles`, `segment`, `normalize`, `resample`) is refused.
"""

FLEET = """
## A fleet

A fleet file, `hydrofdi monitor fleet.yaml`, has these keys and those of a stream ([fleets](../fleets.md)).
"""


def write(reference: Path) -> None:
    """Write ``reference/configuration.md`` and ``reference/samples.md``."""
    write_page(reference / "configuration.md", EXPERIMENT + _keys(ExperimentConfig))
    samples = [
        SAMPLES + _keys(SamplesConfig),
        MEASURED + _keys(MeasuredConfig, SamplesConfig),
        MONITOR + _keys(MonitorConfig, SamplesConfig),
        FLEET + _keys(FleetConfig, MonitorConfig),
    ]
    write_page(reference / "samples.md", "".join(samples).replace("\n## `", "\n### `"))


def _keys(config: type[BaseModel], known: type[BaseModel] = BaseModel) -> str:
    """All keys of a file that are no keys of a known one: plain ones first, then the sections."""
    own = {name: info for name, info in config.model_fields.items() if name not in known.model_fields}
    texts = field_texts(config)
    parts = ["", _table({name: info for name, info in own.items() if _model(info) is None}, texts)]
    names: dict[type[BaseModel], list[str]] = {}
    for name, info in own.items():
        if model := _model(info):
            names.setdefault(model, []).append(name)
    for model, same in names.items():
        is_mapping = typing.get_origin(own[same[0]].annotation) is dict
        parts += _section(same, model, texts.get(same[0]) if is_mapping else None)
    return "\n".join(parts) + "\n"


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
    yield _table(Chart.model_fields, field_texts(Chart))
    for name in chart_names():
        kind = chart_kind(name)
        own = {key: info for key, info in kind.model_fields.items() if key not in Chart.model_fields}
        yield f"\n`{name}`: {kind.summary} {kind.caution}\n"
        if own:
            yield _table(own, field_texts(kind))


def _table(fields: dict[str, FieldInfo], texts: dict[str, str]) -> str:
    rows = [
        (f"`{name}`", _default(info), _allowed(info), _sentence(texts.get(name)))
        for name, info in fields.items()
    ]
    return table(("key", "default", "allowed", "meaning"), rows)


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
