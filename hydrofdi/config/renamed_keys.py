"""Renamed keys, read under their old names for one version."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from typing import Any

from hydrofdi.errors import Mistake, RenamedKeyWarning
from hydrofdi.settings.yaml_source import Path, Source

RENAMED = {
    "run.discard": "analysis.discard",
    "run.duration": "record.duration",
    "run.sampling_frequency": "record.sampling_frequency",
    "run.step": "record.step",
}
"""Dotted key of earlier versions → its present name."""

_OLD_NAME = re.compile(r"\b(" + "|".join(map(re.escape, RENAMED)) + r")\b")


def rename_keys(source: Source) -> None:
    """Give the keys of a source their present names, and warn of each that has an old one.

    A key under both of its names is a mistake of the source.
    """
    source.mistakes.extend(_twice(source, source.data, ()))
    found: dict[str, str] = {}
    for old, new in RENAMED.items():
        section, field = old.split(".")
        if isinstance(source.data, dict) and field in _section(source.data, section):
            found[old] = source.origin((section, field))
            _move_origins(source, (section, field), tuple(new.split(".")))
    for path in list(source.origins):
        for old in RENAMED.keys() & set(path):
            found.setdefault(old, source.origin(path))
            source.origins[tuple(RENAMED.get(str(part), part) for part in path)] = source.origin(path)
    source.data = with_present_keys(source.data)
    for old, origin in found.items():
        place = f"{origin}: " if origin else ""
        message = f"{place}{old} is now {RENAMED[old]}; the next version no longer reads the old name"
        warnings.warn(message, RenamedKeyWarning, stacklevel=2)


def given_twice(old: str) -> str:
    """The message for a key that stands under its old and its present name."""
    return f"give it once: {old} is the old name of {RENAMED[old]}"


def with_present_keys(data: Any) -> Any:
    """Data of an experiment file of this or an earlier version, with the present names of all keys."""
    renamed = _renamed(data)
    if not isinstance(renamed, dict):
        return renamed
    for old, new in RENAMED.items():
        (section, field), (owner, name) = old.split("."), new.split(".")
        if field in _section(renamed, section):
            value = renamed[section].pop(field)
            renamed.setdefault(owner, {})
            if isinstance(renamed[owner], dict):
                renamed[owner].setdefault(name, value)
            if not renamed[section]:
                del renamed[section]
    return renamed


def _twice(source: Source, data: Any, path: Path) -> Iterator[Mistake]:
    """A mistake for each key that stands under both names, with the places of both."""
    if isinstance(data, dict):
        for old, new in RENAMED.items():
            names: list[tuple[Path, Path]] = [((old,), (new,))]
            if not path:
                names.append((tuple(old.split(".")), tuple(new.split("."))))
            for former, present in names:
                if _holds(data, former) and _holds(data, present):
                    place = source.origin((*path, *present))
                    yield source.mistake((*path, *former), f"{given_twice(old)} ({place})")
    parts = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, part in parts:
        yield from _twice(source, part, (*path, key))


def _holds(data: Any, path: Path) -> bool:
    for key in path:
        if not isinstance(data, dict) or key not in data:
            return False
        data = data[key]
    return True


def _section(data: dict[str, Any], name: str) -> dict[str, Any]:
    section = data.get(name)
    return section if isinstance(section, dict) else {}


def _renamed(data: Any) -> Any:
    """Dotted names replaced: keys of mappings, items of lists, and what a condition looks at."""
    if isinstance(data, dict):
        return {
            RENAMED.get(key, key): _in_condition(value) if key == "where" else _renamed(value)
            for key, value in data.items()
        }
    if isinstance(data, list):
        return [RENAMED.get(item, item) if isinstance(item, str) else _renamed(item) for item in data]
    return data


def _in_condition(text: Any) -> Any:
    return _OLD_NAME.sub(lambda match: RENAMED[match[0]], text) if isinstance(text, str) else text


def _move_origins(source: Source, old: Path, new: Path) -> None:
    for path, origin in list(source.origins.items()):
        if path[: len(old)] == old:
            source.origins[(*new, *path[len(old) :])] = origin
