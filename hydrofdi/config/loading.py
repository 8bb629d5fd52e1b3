"""Experiment files and ``--set`` options → a validated experiment, with all mistakes told at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path as FilePath
from typing import Any

from pydantic import BaseModel, ValidationError

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig, complete_baseline
from hydrofdi.config.mistakes import describe_error, nearest
from hydrofdi.config.parameters import parameter_names, validate_parameter
from hydrofdi.config.yaml_source import Path, Source, parse_yaml
from hydrofdi.errors import ConfigError, Mistake

_DOTTED_MAPPINGS: tuple[Path, ...] = (("baseline",), ("sweep", "grid"))
"""Mappings whose keys are dotted parameter names."""


def load_experiment(file: str | FilePath | None = None, settings: Sequence[str] = ()) -> ExperimentConfig:
    """The experiment that a YAML file and ``KEY=VALUE`` settings describe.

    Parameters
    ----------
    file : path, optional
        YAML file; without it every parameter has its nominal value.
    settings : sequence of str
        ``"fluid.bulk_modulus=689 MPa"`` and the like; they win over the file.

    Raises
    ------
    ConfigError
        With every mistake in the file and the settings.
    """
    source = Source({}) if file is None else parse_yaml(_read_text(FilePath(file)), str(file))
    if source.data is not None and not isinstance(source.data, dict):
        source.mistakes.append(source.mistake((), "an experiment file holds 'key: value' pairs"))
        source.data = None
    if source.data is None:
        raise ConfigError(source.mistakes)
    for setting in settings:
        _apply_setting(source, setting)
    return _validate(source)


def _read_text(file: FilePath) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except IsADirectoryError:
        raise ConfigError(f"{file}: is a directory, not an experiment file") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{file}: is not a text file in UTF-8") from None
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None


def _apply_setting(source: Source, setting: str) -> None:
    key, equals, text = setting.partition("=")
    origin = f"--set {setting}"
    if not equals or not key.strip():
        source.mistakes.append(
            Mistake("expected KEY=VALUE, like fluid.bulk_modulus='689 MPa'", origin=origin)
        )
        return
    value = parse_yaml(text, origin)
    path = _setting_path(key.strip())
    parent = source.data
    for part in path[:-1]:
        parent = parent.setdefault(part, {})
        if not isinstance(parent, dict):
            source.mistakes.append(Mistake("is no section", key, origin))
            return
    parent[path[-1]] = value.data
    source.mistakes.extend(value.mistakes)
    source.origins[path] = origin
    source.origins.update(dict.fromkeys(((*path, *inner) for inner in value.origins), origin))


def _setting_path(key: str) -> tuple[str, ...]:
    parts = tuple(key.split("."))
    for mapping in _DOTTED_MAPPINGS:
        if parts[: len(mapping)] == mapping and len(parts) > len(mapping):
            return (*parts[: len(mapping)], ".".join(parts[len(mapping) :]))
    return parts


def _validate(source: Source) -> ExperimentConfig:
    _validate_dotted_mappings(source)
    try:
        experiment = ExperimentConfig.model_validate(source.data)
    except ValidationError as errors:
        source.mistakes.extend(
            source.mistake(_path(error), describe_error(error, _known_keys(_path(error)[:-1])))
            for error in errors.errors()
        )
    if source.mistakes:
        raise ConfigError(sorted(source.mistakes, key=_reading_order))
    return experiment


def _path(error: Any) -> Path:
    return tuple(part for part in error["loc"] if part != "[key]")


def _reading_order(mistake: Mistake) -> tuple[str, int]:
    file, _, line = mistake.origin.rpartition(":")
    return (file, int(line)) if line.isdigit() else (mistake.origin, 0)


def _validate_dotted_mappings(source: Source) -> None:
    """Bring baseline and grid values into SI where they are valid, and note mistakes where they are not."""
    baseline = source.data.get("baseline")
    if baseline is None:
        source.data["baseline"] = baseline = {}
    if isinstance(baseline, dict):
        for name, value in list(baseline.items()):
            baseline[name] = _parameter(source, ("baseline", name), value)
        source.data["baseline"] = complete_baseline(baseline)
        _refuse_both_forms(source, ("baseline",), baseline)
    sweep = source.data.get("sweep")
    if sweep is None:
        source.data.pop("sweep", None)
    grid = sweep.get("grid") if isinstance(sweep, dict) else None
    if isinstance(grid, dict):
        _refuse_both_forms(source, ("sweep", "grid"), grid)
        for name, values in grid.items():
            _validate_axis(source, ("sweep", "grid", name), values)


def _validate_axis(source: Source, path: Path, values: Any) -> None:
    if not isinstance(values, list) or not values:
        source.mistakes.append(source.mistake(path, "an axis is a list of at least one value"))
        return
    for index, value in enumerate(values):
        values[index] = _parameter(source, (*path, index), value)
    for index, value in enumerate(values):
        if value in values[:index]:
            source.mistakes.append(source.mistake((*path, index), f"value {value!r} is in the list twice"))


def _refuse_both_forms(source: Source, path: Path, names: Iterable[str]) -> None:
    if set(INTERNAL_LEAKAGE_FORMS) <= set(names):
        message = "give the internal leakage as internal_coefficient or as internal_flow, not both"
        source.mistakes.append(source.mistake((*path, INTERNAL_LEAKAGE_FORMS[1]), message))


def _parameter(source: Source, path: Path, value: Any) -> Any:
    name = next(str(part) for part in path if "." in str(part) or part == path[-1])
    if name not in (known := list(parameter_names())):
        unknown = source.mistake(path, f"no parameter of this name{nearest(name, known)}")
        if not any(mistake.message == unknown.message for mistake in source.mistakes):
            source.mistakes.append(unknown)
        return value
    try:
        return validate_parameter(name, value)
    except ValidationError as errors:
        for error in errors.errors():
            source.mistakes.append(source.mistake(path, describe_error(error)))
        return value


def _known_keys(path: Path) -> list[str]:
    model: Any = ExperimentConfig
    for part in path:
        field = model.model_fields.get(part) if _is_model(model) else None
        model = field.annotation if field else None
    return list(model.model_fields) if _is_model(model) else []


def _is_model(candidate: Any) -> bool:
    return isinstance(candidate, type) and issubclass(candidate, BaseModel)
