"""Data with line numbers → a strict model, or all mistakes; YAML files that extend others."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Container, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_origin

from pydantic import BaseModel, ValidationError

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import describe_error
from hydrofdi.settings.ready import located, ready_hint
from hydrofdi.settings.yaml_source import Path as Keys
from hydrofdi.settings.yaml_source import Source, dotted, parse_yaml

Model = TypeVar("Model", bound=BaseModel)

_KEY = re.compile(r"\b[a-z][a-z_0-9]*\.[a-z][a-z_0-9]*\b")


def read_yaml(file: Path, kind: str) -> Source:
    """The data of a YAML file, which must be a mapping."""
    source = parse_yaml(read_text(file, kind), str(file))
    if source.mistakes and source.data is None:
        raise ConfigError(source.mistakes)
    if source.data is not None and not isinstance(source.data, dict):
        raise ConfigError([source.mistake((), f"{kind} contains 'key: value' pairs")])
    return source


def validated(model: type[Model], source: Source) -> Model:
    """The model that data describe."""
    try:
        valid = model.model_validate(source.data)
    except ValidationError as errors:
        source.mistakes.extend(_mistake(model, source, error) for error in errors.errors())
    if source.mistakes:
        raise ConfigError(sorted(source.mistakes, key=_reading_order))
    return valid


def _mistake(model: type[BaseModel], source: Source, error: Any) -> Issue:
    path = tuple(part for part in error["loc"] if part != "[key]")
    everywhere = [f"{part}.{key}" for part in model.model_fields for key in known_keys(model, (part,))]
    message = describe_error(error, known_keys(model, path[:-1]), everywhere)
    if error["type"] in ("model_type", "model_attributes_type") and (keys := known_keys(model, path)):
        message += f"; its keys are {', '.join(keys)}"
    return source.mistake(path, message) if path else _placed(source, message)


def _placed(source: Source, message: str) -> Issue:
    """A mistake between keys: at the first stated key, options first, with the places of the others."""
    named = dict.fromkeys(tuple(name.split(".")) for name in _KEY.findall(message))
    places = {path: source.origins[path] for path in named if path in source.origins}
    if not places:
        return source.mistake((), message)
    first, *others = sorted(places, key=lambda path: not places[path].startswith("settings "))
    elsewhere = ", ".join(f"{dotted(path)} is in {places[path]}" for path in others)
    return Issue(f"{message} ({elsewhere})" if elsewhere else message, origin=places[first])


def read_text(file: Path, kind: str) -> str:
    """The text of a file, which should be `kind`."""
    try:
        return file.read_text(encoding="utf-8")
    except IsADirectoryError:
        raise ConfigError(f"{file}: is a directory, not {kind}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{file}: is not a text file in UTF-8") from None
    except FileNotFoundError:
        raise ConfigError(f"{file}: no such file{ready_hint(file)}") from None
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None


def _reading_order(mistake: Issue) -> tuple[str, int]:
    file, _, line = mistake.origin.rpartition(":")
    return (file, int(line)) if line.isdigit() else (mistake.origin, 0)


def known_keys(model: Any, path: Keys) -> list[str]:
    """The keys of the section at a path within a model; none if there is no section."""
    section = _section_at(model, path)
    return list(section.model_fields) if _is_model(section) else []


def _section_at(model: Any, path: Keys) -> Any:
    """The section at a path within a model; None where there is none."""
    parts = iter(path)
    for part in parts:
        if not isinstance(part, int):
            field = model.model_fields.get(part) if _is_model(model) else None
            model = _model_within(field.annotation) if field else None
            if field and get_origin(field.annotation) is dict:
                next(parts, None)
    return model


def _model_within(annotation: Any) -> Any:
    """The model in ``Model``, ``Model | None`` and ``list[Model]``."""
    candidates = [annotation, *getattr(annotation, "__args__", ())]
    return next((candidate for candidate in candidates if _is_model(candidate)), None)


def _is_model(candidate: Any) -> bool:
    return isinstance(candidate, type) and issubclass(candidate, BaseModel)


Merge = Callable[[Mapping[str, Any], Mapping[str, Any]], dict[str, Any]]


def merged(
    base: Mapping[str, Any],
    over: Mapping[str, Any],
    whole: Container[str] = (),
    exclusive: Collection[tuple[str, str]] = (),
) -> dict[str, Any]:
    """Both mappings merged, also within, but not values of `whole` keys; the second wins.

    Its ``null`` removes what is inherited, and its one of an exclusive pair replaces the other.
    """
    pairs = [pair for one, other in exclusive for pair in ((one, other), (other, one))]
    replaced = {other for key, other in pairs if key in over and other not in over}
    mixed = {key: value for key, value in base.items() if key not in replaced}
    for key, value in over.items():
        is_section = isinstance(mixed.get(key), dict) and key not in whole
        if value is None and key in mixed and (is_section or key in whole):
            del mixed[key]
            continue
        both = is_section and isinstance(value, dict)
        mixed[key] = merged(mixed[key], value, whole, exclusive) if both else value
    return mixed


def overlay(base: Source, over: Source, merge: Merge = merged) -> None:
    """Lay a source over another; its keys win."""
    base.data = merge(base.data, over.data)
    base.origins.update(over.origins)
    base.mistakes.extend(over.mistakes)


def read_extended(
    file: Path,
    kind: str,
    prepare: Callable[[Source, Path], None] = lambda own, file: None,
    merge: Merge = merged,
    extending: tuple[Path, ...] = (),
    own: Source | None = None,
) -> Source:
    """A file on top of the files that it extends."""
    if own is None:
        file = located(file)
        if file.resolve() in extending:
            chain = " → ".join(path.name for path in (*extending, file.resolve()))
            raise ConfigError([Issue(f"the files extend each other: {chain}", "extends", str(file))])
        own = read_yaml(file, kind)
    own.data = own.data or {}
    prepare(own, file)
    parents = own.data.pop("extends", [])
    parents = [parents] if isinstance(parents, str) else parents
    if not isinstance(parents, list) or not all(isinstance(parent, str) for parent in parents):
        raise ConfigError([own.mistake(("extends",), "expected the path of a file, or a list of paths")])
    whole = Source({})
    for parent in parents:
        path = located(Path(parent), file.parent)
        if not path.exists():
            hint = ready_hint(Path(parent))
            raise ConfigError([own.mistake(("extends",), f"{path}: no such file{hint}")])
        overlay(whole, read_extended(path, kind, prepare, merge, (*extending, file.resolve())), merge)
    overlay(whole, own, merge)
    return whole
