"""Single values of dotted parameters: converted to SI if valid, reported as mistakes if not."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.request import RunRequest, parameter_names, parameter_unit, validate_parameter
from hydrofdi.settings.messages import describe_error, nearest
from hydrofdi.settings.quantities import SI
from hydrofdi.settings.yaml_source import Path, Source, dotted


def parameter_value(source: Source, path: Path, name: str, value: Any) -> Any:
    """A parameter value in SI; if it is invalid, the value unchanged, and the source gets a mistake."""
    known = list(parameter_names())
    if name not in known:
        place = path[: path.index(name) + 1]
        unknown = source.mistake(place, f"no parameter {name!r}{nearest(name, known)}")
        if not any(mistake.message == unknown.message for mistake in source.mistakes):
            source.mistakes.append(unknown)
        return value
    try:
        return validate_parameter(name, value)
    except ValidationError as errors:
        for error in errors.errors():
            source.report(path, describe_error(error))
        return value


Conversion = Callable[[Source, Path, str, Any], Any]
"""Source, path, dotted parameter, and what is written for it → the same in SI."""


def convert_mapping(source: Source, section: Any, key: str, path: Path, in_si: Conversion) -> list[str]:
    """Convert what a mapping of a section says of dotted parameters to SI, and return their names.

    What is no mapping is left to the validation of the model.
    """
    mapping = section.get(key) if isinstance(section, dict) else None
    if not isinstance(mapping, dict):
        return []
    section[key] = {name: in_si(source, (*path, key, name), name, value) for name, value in mapping.items()}
    return list(mapping)


def nominal_value(source: Source, name: str) -> Any:
    """The nominal value of a parameter in SI: the given one, else the default; None if it is invalid."""
    section, field = name.split(".")
    given = source.data.get(section)
    if not isinstance(given, dict) or field not in given:
        return getattr(RunRequest.model_fields[section].default, field)
    try:
        return validate_parameter(name, given[field])
    except ValidationError:  # validation of the model reports it
        return None


def is_stated(source: Source, name: str) -> bool:
    """Whether a source gives a parameter a nominal value, valid or not."""
    section, field = name.split(".")
    given = source.data.get(section)
    return isinstance(given, dict) and given.get(field) is not None


def difference(name: str, value: Any) -> float:
    """A difference of two values of a parameter, in SI.

    Raises
    ------
    ValueError
        It is not a finite number with a suitable unit.
    """
    unit = parameter_unit(name) if name in parameter_names() else None
    number = SI(unit or "1").parse(value)
    if not math.isfinite(number):
        raise ValueError(f"must be a finite number; found {value}")
    return number


def require_numbers(source: Source, path: Path) -> None:
    """Report that the ends must be numbers, unless another mistake in them is already reported."""
    if not any(mistake.where.startswith(dotted(path[:-1])) for mistake in source.mistakes):
        source.report(path, "its ends must be numbers")
