"""Values under dotted parameter names: converted to SI if valid, reported as mistakes if not."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from pydantic import ValidationError

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.request import parameter_names, parameter_unit, validate_parameter
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.config.sweeps.condition import parse_condition
from hydrofdi.config.sweeps.distributions import distribution_in_si
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.config.sweeps.values import convert_mapping, difference, parameter_value, require_numbers
from hydrofdi.settings.messages import describe_error, nearest
from hydrofdi.settings.yaml_source import Path, Source, dotted
from hydrofdi.units import parse_quantity

_MOST_VALUES = 1_000_000
_GENERATORS = ("linspace", "logspace", "arange")


def normalize_baseline(source: Source) -> None:
    """Convert the ``baseline`` of a source to SI."""
    if source.data.get("baseline") is None:
        source.data.pop("baseline", None)
    names = convert_mapping(source, source.data, "baseline", (), parameter_value)
    _refuse_both_forms(source, ("baseline",), names)
    for name in set(INTERNAL_LEAKAGE_FORMS).intersection(names):
        value = source.data["baseline"][name]
        if isinstance(value, float) and value > 0.0:
            message = "a leaking baseline is not a healthy actuator; remove it, or set 0"
            source.report(("baseline", name), message)


def normalize_replicates(source: Source) -> None:
    """Convert the distributions of ``replicates`` to SI."""
    convert_mapping(source, source.data.get("replicates"), "over", ("replicates",), distribution_in_si)


def normalize_sweep(source: Source) -> None:
    """Convert the ``sweep`` and ``ensemble`` of a source to SI, and expand generators of values."""
    for section in ("sweep", "ensemble"):
        if source.data.get(section) is None:
            source.data.pop(section, None)
        else:
            _normalize_block(source, (section,), source.data[section])


def _normalize_block(source: Source, path: Path, block: Any) -> None:
    if not isinstance(block, dict):
        return
    _refuse_outside_grid(source, path, block)
    for kind in ("grid", "zip"):
        if block.get(kind) == {}:
            source.report((*path, kind), "names no parameter to vary")
    varied = [
        *convert_mapping(source, block, "grid", path, axis_in_si),
        *convert_mapping(source, block, "zip", path, axis_in_si),
        *convert_mapping(source, block.get("sample"), "over", (*path, "sample"), distribution_in_si),
    ]
    _refuse_both_forms(source, path, varied)
    _check_condition(source, (*path, "where"), block.get("where"))
    union = block.get("union")
    if isinstance(union, list):
        for index, part in enumerate(union):
            _normalize_block(source, (*path, "union", index), part)


def _refuse_outside_grid(source: Source, path: Path, block: dict[str, Any]) -> None:
    """Refuse parameters, or sections of parameters, beside ``grid`` instead of in it."""
    for key in [key for key in block if key not in SweepConfig.model_fields]:
        if known := [name for name in parameter_names() if key in (name, *name.split("."))]:
            put = "it" if key in known else f"dotted parameters such as {known[0]!r}"
            source.report((*path, key), f"put {put} under {dotted((*path, 'grid'))}")
            del block[key]


def axis_in_si(source: Source, path: Path, name: str, values: Any) -> Any:
    """An axis as a list of values in SI."""
    if isinstance(values, dict):
        return _generated(source, path, name, values)
    if not isinstance(values, list) or not values:
        source.report(path, "an axis is a list of at least one value, or one of linspace, logspace, arange")
        return []
    converted = [parameter_value(source, (*path, index), name, value) for index, value in enumerate(values)]
    for index, value in enumerate(converted):
        if value in converted[:index] and path[-2] != "zip":
            source.report((*path, index), f"value {without_contents(value)!r} is in the list twice")
    return converted


def _generated(source: Source, path: Path, name: str, generator: dict[str, Any]) -> list[Any]:
    if len(generator) != 1 or (kind := next(iter(generator))) not in _GENERATORS:
        known = ", ".join(_GENERATORS)
        source.report(path, f"an axis is a list, or one of {known}")
        return []
    path, arguments = (*path, kind), generator[kind]
    if not isinstance(arguments, list) or len(arguments) != 3:
        third = "step" if kind == "arange" else "count"
        source.report(path, f"expected [first, last, {third}]; found {arguments!r}")
        return []
    first, last = (parameter_value(source, (*path, index), name, arguments[index]) for index in (0, 1))
    if not all(isinstance(end, int | float) for end in (first, last)):
        require_numbers(source, path)
        return []
    try:
        values = _range(kind, first, last, _third(kind, name, arguments[2]))
        if isinstance(first, int):
            return [validate_parameter(name, int(value) if value.is_integer() else value) for value in values]
        return [validate_parameter(name, value) for value in values]
    except ValueError as error:
        source.report(path, _first_message(error))
        return []


def _third(kind: str, name: str, value: Any) -> float:
    """The count of linspace and logspace, or the step of arange in SI."""
    if kind == "arange":
        return difference(name, value)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= _MOST_VALUES:
        raise ValueError(f"the count must be an integer from 1 to {_MOST_VALUES}; found {value!r}")
    return value


def _range(kind: str, first: float, last: float, third: float) -> list[float]:
    if kind == "linspace":
        return [float(value) for value in np.linspace(first, last, int(third))]
    if kind == "logspace":
        if first <= 0.0 or last <= 0.0:
            raise ValueError("logspace needs ends above zero")
        return [float(value) for value in np.geomspace(first, last, int(third))]
    count = math.ceil((last - first) / third - 1e-9) if third else 0
    if not 1 <= count <= _MOST_VALUES:
        raise ValueError(f"arange from {first:g} to below {last:g} by {third:g} gives no values, or too many")
    return [float(first + index * third) for index in range(count)]


def _check_condition(source: Source, path: Path, text: Any) -> None:
    if not isinstance(text, str):
        return
    try:
        condition = parse_condition(text)
    except ValueError:
        return  # validation of the model reports it
    known = list(parameter_names())
    for name in sorted(condition.names - set(known)):
        source.report(path, f"no parameter {name!r}{nearest(name, known)}")
    for name, quantity in condition.compared:
        if name in known and (unit := parameter_unit(name)) is not None:
            try:
                parse_quantity(quantity, unit)
            except ValueError as error:
                source.report(path, f"{name} cannot be compared with this quantity: {error}")


def _refuse_both_forms(source: Source, path: Path, names: Iterable[str]) -> None:
    if set(INTERNAL_LEAKAGE_FORMS) <= set(names):
        source.report(path, "give the internal leakage as internal_coefficient or as internal_flow, not both")


def _first_message(error: ValueError) -> str:
    return describe_error(error.errors()[0]) if isinstance(error, ValidationError) else str(error)
