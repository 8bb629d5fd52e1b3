"""The units that an experiment is written in, so that people read its numbers in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.settings.yaml_source import Source
from hydrofdi.units import parse_unit, stated_unit


def note_written_units(source: Source) -> None:
    """Add to ``units`` of a source the first unit that each parameter is written with; stated units win."""
    if not isinstance(source.data, dict) or not isinstance(stated := source.data.get("units") or {}, dict):
        return
    units: dict[str, str] = {}
    for name, value in _parameters(source.data, "", frozenset(parameter_names())):
        if name not in units and (unit := _unit_of(name, value)):
            units[name] = unit
    if units or stated:
        source.data["units"] = units | stated


def _parameters(data: Mapping[str, Any], section: str, known: Set[str]) -> Iterator[tuple[str, Any]]:
    """Dotted names and what is written for them, in sections, axes, distributions and populations alike."""
    for key, value in data.items():
        name = key if key in known else f"{section}.{key}"
        if name in known:
            yield name, value
            continue
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, Mapping):
                yield from _parameters(part, key, known)


def _unit_of(name: str, value: Any) -> str | None:
    """The first unit in which a value is written, other than the SI unit; none of leakage flows."""
    own = parameter_unit(name)
    if own is None or name in INTERNAL_LEAKAGE_FORMS:
        return None
    units = (stated_unit(text, own) for text in _texts(value))
    return next((unit for unit in units if unit and parse_unit(unit) != parse_unit(own)), None)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list | Mapping):
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from _texts(part)
