"""What a file writes for dotted parameters → values in SI; what is wrong is collected with its place."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
from pydantic import ValidationError

from hydrofdi.config import plant
from hydrofdi.config.drive import without_contents
from hydrofdi.config.experiment import DWT, INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.request import RunRequest, meant, parameter_names, parameter_unit, validate_parameter
from hydrofdi.config.sweep import ENDS, GENERATORS
from hydrofdi.config.values import LAWS, argument_values, is_number, require_law
from hydrofdi.errors import ConfigError
from hydrofdi.settings.files import Keys as Path
from hydrofdi.settings.files import Source, scalar
from hydrofdi.settings.messages import brief, describe_error, nearest, similar
from hydrofdi.settings.quantities import SI
from hydrofdi.units import parse_quantity

_MOST_VALUES = 1_000_000
_AXIS = (
    "an axis is a list of values, {from, to, num}, {from, to, step}, {linspace: [first, last, count]} (or"
    " logspace, geomspace), {arange: [first, last, step]}, or a text such as '551 MPa:827 MPa:3'"
)
_DISTRIBUTIONS: dict[str, tuple[str, ...]] = {kind: law.arguments for kind, law in LAWS.items()}
_DISTRIBUTIONS["choice"] = ()
"""Kind → its arguments; any number of values where there are none."""

_ABOUT = re.compile(r"\s*(?:±|\+/-|\+-)\s*(.*)", re.DOTALL)
"""A width about the nominal value, such as ``±20 %`` or ``±1 µm``."""

_ARGUMENTS_ABOUT = {
    "uniform": lambda nominal, width: [nominal - width, nominal + width],
    "triangular": lambda nominal, width: [nominal - width, nominal, nominal + width],
    "normal": lambda nominal, width: [nominal, width],
}
"""Distribution → its arguments from the nominal value and the width after ``±``."""

_NOTHING: dict[str, list[Any]] = {"uniform": []}
"""In place of what is invalid, so that validation of the model does not report it again."""

_SEEDS = [0, 2**31 - 1]


def normalize(source: Source) -> None:
    """All that a source says of dotted parameters in SI; ``indicators`` has to be normalized before."""
    data = source.data
    _normalize_plant(source)
    for section in ("baseline", "sweep", "ensemble", "study"):
        if data.get(section, ...) is None:
            del data[section]
    names = _convert(source, data, ("baseline",), parameter_value)
    _refuse_both_forms(source, ("baseline",), names)
    for name in set(INTERNAL_LEAKAGE_FORMS).intersection(names):
        value = data["baseline"][name]
        if isinstance(value, float) and value > 0.0:
            message = "a leaking baseline is not a healthy actuator; remove it, or set 0"
            source.report(("baseline", name), message)
    for section in ("sweep", "ensemble"):
        _normalize_block(source, (section,), data.get(section))
    if isinstance(study := data.get("study"), dict):
        _normalize_study(source, study)


def _normalize_plant(source: Source) -> None:
    """The FMU made known; its parameters in SI, and what those are without being stated that vary."""
    section = source.data.get("plant")
    if not isinstance(section, dict) or not isinstance(section.get("fmu"), str):
        return
    try:
        section["fmu"] = plant.with_digest(section["fmu"])
        model = plant.named_model(section["fmu"])
    except ConfigError as error:
        source.report(("plant", "fmu"), str(error))
        raise ConfigError(source.mistakes) from None  # nothing else of the plant can be judged
    if model is not None:
        plant.declare(model)
    own = {key: section.pop(key) for key in [*section] if key not in plant.PlantConfig.model_fields}
    for keys, value in _leaves(own):
        n_mistake, key = len(source.mistakes), ".".join(keys)
        source.move(("plant", *keys), ("plant", key))
        value = parameter_value(source, ("plant", key), f"plant.{key}", value)
        if len(source.mistakes) == n_mistake:  # else validation of the model would report it again
            section[key] = value
    varied = {key for key in _keys({**source.data, "plant": {}}) if plant.is_foreign(key)}
    for name in sorted(varied):
        if (start := plant.foreign_start(name)) is not None:
            section.setdefault(name.partition(".")[2], start)
    _keep_own_leak(source, section)
    stated = ((key, parameter_unit(f"plant.{key}")) for key in section if plant.is_foreign(f"plant.{key}"))
    section["units"] = {key: unit for key, unit in stated if unit}


def _keep_own_leak(source: Source, section: dict[str, Any]) -> None:
    """A leak that the FMU has by itself is that of the experiment, unless it states one."""
    leakage, stated = section.get("leakage"), source.data.setdefault("leakage", {})
    own = plant.foreign_start(f"plant.{leakage.get('coefficient')}") if isinstance(leakage, dict) else None
    forms = {name.partition(".")[2] for name in INTERNAL_LEAKAGE_FORMS}
    if own and isinstance(stated, dict) and not stated.keys() & forms:
        stated["internal_coefficient"] = own


def _leaves(value: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Values of nested mappings, with their keys."""
    if not isinstance(value, dict):
        yield path, value
        return
    for key, inner in value.items():
        yield from _leaves(inner, (*path, str(key)))


Conversion = Callable[[Source, Path, str, Any], Any]
"""Source, path, dotted parameter, and what is written for it → the same in SI."""


def _convert(source: Source, section: Any, path: Path, in_si: Conversion) -> list[str]:
    """Convert the mapping at a path, if it is one, and return its dotted parameters."""
    mapping = section.get(path[-1]) if isinstance(section, dict) else None
    if not isinstance(mapping, dict):
        return []
    for name, value in mapping.items():
        if name in parameter_names():
            mapping[name] = in_si(source, (*path, name), name, value)
        else:
            source.report((*path, name), f"no parameter {name!r}{meant(name)}")
            mapping[name] = [] if in_si in (axis_in_si, _levels) else _NOTHING
    return list(mapping)


def parameter_value(source: Source, path: Path, name: str, value: Any) -> Any:
    """A parameter value in SI; if it is invalid, the value unchanged, and the source gets a mistake."""
    with _reported(source, path):
        own = plant.PARAMETERS.get(name)
        if own and (own.factor, own.offset) != (1.0, 0.0) and is_number(value):
            example = f"'{value:g} {own.unit}', as in the FMU"
            raise ValueError(f"{value:g} has no unit; write {example}, or one of SI")
        return validate_parameter(name, value)
    return value


@contextmanager
def _reported(source: Source, path: Path, said: str = "") -> Iterator[None]:
    """Collect what is invalid within as a mistake at a path."""
    try:
        yield
    except ValidationError as errors:
        for error in errors.errors():
            source.report(path, f"{said}{describe_error(error)}")
    except ValueError as error:
        source.report(path, f"{said}{error}")


def _changed_value(source: Source, path: Path, name: str, value: Any) -> Any:
    """A distribution, or a value; ``+25 %`` and ``−25 %`` are relative to the nominal value."""
    if isinstance(value, Mapping):
        return distribution_in_si(source, path, name, value)
    if not (isinstance(value, str) and re.fullmatch(r"\s*[-+−].*%\s*", value)):
        return parameter_value(source, path, name, value)
    nominal = nominal_value(source, name)
    with _reported(source, path):
        change = parse_quantity(value.replace("−", "-"), "1")
        if not isinstance(nominal, float) or not nominal * change:
            raise ValueError(f"{value} of the nominal {nominal!r} is no change; state the value itself")
        return validate_parameter(name, nominal * (1.0 + change))
    return value


def nominal_value(source: Source, name: str) -> Any:
    """The nominal value of a parameter in SI: the given one, else the default; None if it is invalid."""
    if (given := _given(source, name)) is None:
        if plant.is_foreign(name):
            return plant.foreign_start(name)
        section, field = name.split(".")
        return getattr(RunRequest.model_fields[section].default, field)
    with suppress(ValidationError):  # validation of the model reports it
        return validate_parameter(name, given)
    return None


def _given(source: Source, name: str) -> Any:
    """The nominal value that a source gives a parameter, valid or not."""
    section, _, field = name.partition(".")
    given = source.data.get(section)
    return given.get(field) if isinstance(given, dict) else None


def _arguments(source: Source, path: Path, name: str, roles: tuple[str, ...], stated: Any) -> list[Any]:
    """The arguments of a generator or of a distribution in SI; none, with a mistake, if one is invalid."""
    if not isinstance(stated, list) or not stated or (roles and len(stated) != len(roles)):
        source.report(path, f"expected [{', '.join(roles) or 'value, …'}]; found {stated!r}")
        return []
    n_mistake = len(source.mistakes)
    values = [
        _argument(source, (*path, index), name, role, value)
        for index, (role, value) in enumerate(zip(roles or [""] * len(stated), stated, strict=True))
    ]
    if not roles or all(map(is_number, values)):
        return values
    if len(source.mistakes) == n_mistake:
        source.report(path, "its ends must be numbers")
    return []


def _argument(source: Source, path: Path, name: str, role: str, value: Any) -> Any:
    """An argument in SI: a value of the parameter, a difference of two, or a number without a unit."""
    if role not in ("deviation", "factor", "step", "count"):
        return parameter_value(source, path, name, value)
    with _reported(source, path):
        if role != "count":
            return _difference("" if role == "factor" else name, value)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= _MOST_VALUES:
            raise ValueError(f"the count must be an integer from 1 to {_MOST_VALUES}; found {value!r}")
        return value
    return None


def _difference(name: str, value: Any) -> float:
    number = SI((parameter_unit(name) if name else None) or "1").parse(value)
    if not math.isfinite(number):
        raise ValueError(f"must be a finite number; found {value}")
    return number


def distribution_in_si(source: Source, path: Path, name: str, stated: Any) -> Any:
    """A distribution with its arguments in SI; if invalid, an empty one, and the source gets a mistake."""
    if not isinstance(stated, dict) or len(stated) != 1:
        source.report(path, f"expected one of {', '.join(_DISTRIBUTIONS)}, such as {{uniform: […]}}")
        return _NOTHING
    ((kind, arguments),) = stated.items()
    path = (*path, kind)
    if kind not in _DISTRIBUTIONS:
        source.report(path, f"is unknown{nearest(kind, list(_DISTRIBUTIONS))}")
        return _NOTHING
    if isinstance(arguments, str) and (about := _ABOUT.fullmatch(arguments)):
        values = _about_nominal(source, path, name, kind, about[1])
    else:
        values = _arguments(source, path, name, _DISTRIBUTIONS[kind], arguments)
    with _reported(source, path):
        if values and kind in LAWS:
            require_law(name, kind, values)
        return {kind: values} if values else _NOTHING
    return _NOTHING


def _about_nominal(source: Source, path: Path, name: str, kind: str, width: str) -> list[float]:
    """The arguments of a distribution about the nominal value of its parameter."""
    nominal = nominal_value(source, name)
    if nominal is None and _given(source, name) is not None:  # validation of the model reports it
        return []
    with _reported(source, path, f"±{width}: "):
        if kind not in _ARGUMENTS_ABOUT or not isinstance(nominal, float):
            raise ValueError(f"± needs a real number, and one of {', '.join(_ARGUMENTS_ABOUT)}")
        size = abs(nominal) * parse_quantity(width, "1") if width.endswith("%") else _difference(name, width)
        if not 0.0 < size < math.inf:
            raise ValueError(f"the width after ± must be finite and greater than 0; found {width}")
        arguments: list[float] = _ARGUMENTS_ABOUT[kind](nominal, size)
        for value in argument_values({kind: arguments}):
            validate_parameter(name, value)
        return arguments
    return []


def axis_in_si(source: Source, path: Path, name: str, stated: Any) -> list[Any]:
    """An axis as a list of values in SI."""
    if isinstance(stated, str) and (ends := _ends_of_text(stated)):
        stated = ends
    if isinstance(stated, dict):
        return _generated(source, path, name, stated)
    if not isinstance(stated, list) or not stated:
        source.report(path, f"{_AXIS}; found {brief(stated)}")
        return []
    values = [parameter_value(source, (*path, index), name, value) for index, value in enumerate(stated)]
    first: dict[str, int] = {}
    for index, value in enumerate(values):
        if first.setdefault(repr(value), index) != index and path[-2] != "zip":
            source.report((*path, index), f"value {without_contents(value)!r} is in the list twice")
    return values


def _ends_of_text(text: str) -> dict[str, Any]:
    """``first:last:count``, ``first:last:count:log`` or ``first:last:step``, whose step has a unit."""
    parts = [scalar(part.strip()) for part in text.split(":")]
    # Ends in different units are a slip; zero needs none.
    if (
        len(parts) not in (3, 4)
        or parts[3:] not in ([], ["log"])
        or len({type(end) is str for end in parts[:2] if end}) > 1
    ):
        return {}
    kind = "logspace" if parts[3:] else "linspace" if isinstance(parts[2], int) else "steps"
    return {kind: parts[:3]}


def _generated(source: Source, path: Path, name: str, stated: dict[str, Any]) -> list[Any]:
    roles = {ENDS[key]: value for key, value in stated.items() if key in ENDS}
    if len(roles) == len(stated) == 3 and roles.keys() >= {"first", "last"}:
        kind = "linspace" if "count" in roles else "steps"
        stated = {kind: [roles.pop("first"), roles.pop("last"), *roles.values()]}
    if len(stated) != 1 or not stated.keys() <= GENERATORS.keys():
        known = [*ENDS, *GENERATORS]
        meant = "".join(similar(key, known) for key in stated if key not in known)
        source.report(path, f"{_AXIS}; found {brief(stated)}{meant}")
        return []
    ((kind, arguments),) = stated.items()
    path = (*path, kind)
    ends = _arguments(source, path, name, GENERATORS[kind], arguments)
    with _reported(source, path):
        values = _range(kind, *ends) if ends else []
        are_whole = bool(ends) and isinstance(ends[0], int)
        return [
            validate_parameter(name, int(value) if are_whole and value.is_integer() else value)
            for value in values
        ]
    return []


def _range(kind: str, first: float, last: float, third: float) -> list[float]:
    if kind in ("logspace", "geomspace") and min(first, last) <= 0.0:
        raise ValueError(f"{kind} needs ends above zero")
    if GENERATORS[kind][2] == "count":
        space = np.linspace if kind == "linspace" else np.geomspace
        return [*map(float, space(first, last, int(third)))]
    steps = (last - first) / third if third else 0.0
    count = math.ceil(steps - 1e-9) if kind == "arange" else math.floor(steps + 1e-9) + 1
    if not third or not 1 <= count <= _MOST_VALUES:
        raise ValueError(f"from {first:g} to {last:g} by {third:g} gives no values, or too many")
    return [float(first + index * third) for index in range(count)]


def _normalize_block(source: Source, path: Path, block: Any) -> None:
    if not isinstance(block, dict):
        return
    for kind in ("grid", "zip"):
        if block.get(kind) == {}:
            source.report((*path, kind), "names no parameter to vary")
    varied = [
        *_convert(source, block, (*path, "grid"), axis_in_si),
        *_convert(source, block, (*path, "zip"), axis_in_si),
        *_convert(source, block.get("sample"), (*path, "sample", "over"), distribution_in_si),
    ]
    _refuse_both_forms(source, path, varied)
    if isinstance(union := block.get("union"), list):
        for index, part in enumerate(union):
            _normalize_block(source, (*path, "union", index), part)


def _refuse_both_forms(source: Source, path: Path, names: Iterable[str]) -> None:
    if set(INTERNAL_LEAKAGE_FORMS) <= set(names):
        source.report(path, "give the internal leakage as internal_coefficient or as internal_flow, not both")


def _normalize_study(source: Source, study: dict[str, Any]) -> None:
    """A study with what is drawn and kept unless the file says otherwise; without parts that are null."""
    sections: list[Any] = [study, study.get("population")]
    for section in sections:
        for name in [*section] if isinstance(section, dict) else ():
            if section[name] is None:
                del section[name]
    population = study.setdefault("population", {})
    _normalize_faults(source, study.get("faults"))
    for kind in ("shifts", "confusions"):
        named: Any = study.get(kind)
        for name in named if isinstance(named, dict) else ():
            path = ("study", kind, name)
            if not named[name] or not isinstance(named[name], dict):
                message = "expected 'parameter: value' or 'parameter: {distribution}' pairs"
                source.report(path, f"{message}; found {named[name]!r}")
                named[name] = {}
            _convert(source, named, path, _changed_value)
    if isinstance(population, dict):
        for kind in ("over", "per_record"):
            population.setdefault(kind, {})
            _convert(source, population, ("study", "population", kind), distribution_in_si)
        if isinstance(population["per_record"], dict):
            _draw_per_record(source, population["per_record"], population["over"])
    for section, field, value in (("calibration", "at", "nominal"), ("store", "signals", "none")):
        if isinstance(given := source.data.setdefault(section, {}), dict):
            given.setdefault(field, value)


def _normalize_faults(source: Source, faults: Any) -> None:
    """Faults with their axis under ``over``, also where it stands beside the counts."""
    if not isinstance(faults, dict):
        return
    path: Path = ("study", "faults")
    if isinstance(over := faults.setdefault("over", {}), dict):
        for name in [name for name in faults if "." in name]:
            over[name] = faults.pop(name)
            source.move((*path, name), (*path, "over", name))
    _convert(source, faults, (*path, "over"), _levels)


def _levels(source: Source, path: Path, name: str, stated: Any) -> list[float]:
    """The levels that are numbers; each of the others is a mistake of the source."""
    levels = axis_in_si(source, path, name, stated)
    for index, level in enumerate(levels):
        if level is None:
            source.report((*path, index), "a level is a number with a unit, not null")
    return [level for level in levels if isinstance(level, float)]


def _draw_per_record(source: Source, per_record: dict[str, Any], over: Any) -> None:
    """Draw what differs from record to record, unless the source names it."""
    usual: dict[str, list[int]] = {"measurement.seed": _SEEDS}
    if DWT in source.data.get("indicators", {DWT: {}}):
        levels = nominal_value(source, "wavelet.levels")
        usual["wavelet.phase"] = [0, 2**levels - 1] if isinstance(levels, int) else [0, 0]
    if nominal_value(source, "input.shape") == "steps":
        usual["input.seed"] = _SEEDS
    if nominal_value(source, "load.random_force"):
        usual["load.seed"] = _SEEDS
    named = {*per_record, *(over if isinstance(over, dict) else ()), *_keys(source.data.get("sweep"))}
    for name, ends in usual.items():
        if name not in named and (name == "measurement.seed" or _given(source, name) is None):
            per_record[name] = {"integers": ends}


def _keys(data: Any) -> Iterator[str]:
    """Keys of mappings, and of those within."""
    for key in data if isinstance(data, dict) else ():
        yield from (key, *_keys(data[key]))
    for part in data if isinstance(data, list) else ():
        yield from _keys(part)
