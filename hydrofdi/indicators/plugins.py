"""Indicators in Python files that an experiment names; ``swing@…`` is the ``swing`` of a file with that hash.

Only an experiment that the user gives has files executed; worker processes get their content with the jobs.
"""

from __future__ import annotations

import hashlib
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.registry import FROM_FILES, Kind, indicator_names, require_declared
from hydrofdi.indicators.selection import label_mistake
from hydrofdi.settings.files import Source
from hydrofdi.settings.messages import brief

_SOURCES: dict[str, tuple[str, bytes]] = {}
"""Hash → path and content of each file that was executed."""


def load_plugins(source: Source) -> dict[str, str]:
    """Execute the files in ``plugins`` of an experiment; these then are path → SHA-256.

    Returns
    -------
    dict of str to str
        Name of each of their indicators → the name with the hash.

    Raises
    ------
    ConfigError
        A file cannot be read, raises an exception, or defines no indicator, or one with a name of another.
    """
    given = source.data.get("plugins") or []
    paths = [given] if isinstance(given, str) else given
    if not isinstance(paths, list) or not all(isinstance(path, str) for path in paths):
        message = f"expected the path of a Python file, or a list of paths; found {brief(given)}"
        raise ConfigError([source.mistake(("plugins",), message)])
    names: dict[str, str] = {}
    hashes: dict[str, str] = {}
    for place, path in enumerate(paths):
        here = ("plugins", place) if paths is given else ("plugins",)
        try:
            content, whole = Path(path).read_bytes(), str(Path(path).resolve())
            found = load_plugin(whole, content)
        except (OSError, ConfigError) as error:
            source.report(here, f"{path}: {error.strerror}" if isinstance(error, OSError) else str(error))
            continue
        if twice := names.keys() & found.keys():
            source.report(here, f"{path}: {min(twice)!r} is the name of another indicator")
        names |= found
        hashes[whole] = hashlib.sha256(content).hexdigest()
    if paths and source.mistakes:
        raise ConfigError(source.mistakes)
    if "plugins" in source.data:
        source.data["plugins"] = hashes
    return names


def load_plugin(path: str, content: bytes) -> dict[str, str]:
    """Execute a file, once in a process; `load_plugins` of one."""
    mark = f"@{hashlib.sha256(content).hexdigest()[:16]}"
    if mark not in _SOURCES:
        kinds = _kinds(path, content, f"plugin{mark}")
        for kind in kinds:
            kind.name += mark
            FROM_FILES[kind.name] = kind
        _SOURCES[mark] = path, content
    return {name.removesuffix(mark): name for name in FROM_FILES if name.endswith(mark)}


def sources_in(text: str) -> list[tuple[str, bytes]]:
    """Path and content of the files whose indicators a text names."""
    return [source for mark, source in _SOURCES.items() if mark in text]


def _kinds(path: str, content: bytes, module_name: str) -> list[Kind]:
    module = ModuleType(module_name)
    module.__file__ = path
    sys.modules[module_name] = module  # where pydantic looks up the annotations of options
    try:
        exec(compile(content, path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [each.lineno for each in frames if each.filename == path]
        place = f" ({Path(path).name}:{lines[-1]})" if lines else ""
        raise ConfigError(f"{path}: raised {type(error).__name__}: {error}{place}") from None
    kinds = list(dict.fromkeys(each for each in vars(module).values() if _is_own(each, module_name)))
    if not kinds:
        raise ConfigError(f"{path}: defines no indicator, a subclass of Indicator with a name")
    for kind in kinds:
        require_declared(kind, path)
        mistake = label_mistake(kind.name)
        if mistake or kind.name in indicator_names() or [each.name for each in kinds].count(kind.name) > 1:
            raise ConfigError(f"{path}: {kind.name!r} {mistake or 'is the name of another indicator'}")
    return kinds


def _is_own(value: Any, module_name: str) -> bool:
    is_indicator = isinstance(value, type) and Indicator in value.__mro__ and hasattr(value, "name")
    return is_indicator and value.__module__ == module_name
