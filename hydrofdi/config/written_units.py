"""The units that an experiment is written in, so that people read its numbers in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.settings.yaml_source import Source
from hydrofdi.units import parse_unit, stated_unit


def note_written_units(source: Source) -> None:
    """Add to ``units`` of a source the unit that each of its values is written with; what it states wins."""
    if isinstance(source.data, dict) and isinstance(stated := source.data.get("units") or {}, dict):
        units = dict(reversed([*_units(source.data, "")])) | stated
        if units:
            source.data["units"] = units


def _units(data: Mapping[str, Any], section: str) -> Iterator[tuple[str, str]]:
    """Dotted names with the units of their values, wherever they stand; the SI unit itself is left out."""
    known = set(parameter_names())
    for key, value in data.items():
        name = key if key in known else f"{section}.{key}"
        if name in known:
            yield from ((name, unit) for unit in _units_of(name, value))
            continue
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, Mapping):
                yield from _units(part, key)


def _units_of(name: str, value: Any) -> Iterator[str]:
    own = parameter_unit(name)
    if isinstance(value, Mapping):
        value = [*value.values()]
    if isinstance(value, list):
        for item in value:
            yield from _units_of(name, item)
    elif own and name not in INTERNAL_LEAKAGE_FORMS and isinstance(value, str):
        unit = stated_unit(value, own)
        if unit and parse_unit(unit) != parse_unit(own):
            yield unit
