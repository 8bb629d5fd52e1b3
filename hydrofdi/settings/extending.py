"""YAML files that extend others (``extends: other.yaml``), whose keys they override."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.ready import located, ready_hint
from hydrofdi.settings.validation import read_yaml
from hydrofdi.settings.yaml_source import Source

Merge = Callable[[Mapping[str, Any], Mapping[str, Any]], dict[str, Any]]


def merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Both mappings merged, also within; the second wins, and its ``null`` removes a mapping."""
    whole = dict(base)
    for key, value in over.items():
        if value is None and isinstance(whole.get(key), dict):
            del whole[key]
            continue
        both = isinstance(value, dict) and isinstance(whole.get(key), dict)
        whole[key] = merged(whole[key], value) if both else value
    return whole


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
) -> Source:
    """A file on top of the files that it extends.

    Parameters
    ----------
    file : path
        Or the name of a ready configuration, as those that it extends may be.
    kind : str
        What the file should be, such as ``an experiment file``.
    prepare : callable, optional
        Called with the data of each file, and the file.
    merge : callable, optional
        Lays data over others.
    extending : tuple of path
        Files that extend this one.

    Raises
    ------
    ConfigError
        A file cannot be read, or the files extend each other.
    """
    file = located(file)
    if file.resolve() in extending:
        chain = " → ".join(path.name for path in (*extending, file.resolve()))
        raise ConfigError([Issue(f"the files extend each other: {chain}", "extends", str(file))])
    return extended(read_yaml(file, kind), file, kind, prepare, merge, extending)


def extended(
    own: Source,
    file: Path,
    kind: str,
    prepare: Callable[[Source, Path], None] = lambda own, file: None,
    merge: Merge = merged,
    extending: tuple[Path, ...] = (),
) -> Source:
    """Data on top of the files that they extend, as `read_extended` reads them from a file.

    Parameters
    ----------
    own : Source
    file : path
        Where paths in the data start from: its folder.
    kind, prepare, merge, extending
        As in `read_extended`.

    Raises
    ------
    ConfigError
        A file cannot be read, or the files extend each other.
    """
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
