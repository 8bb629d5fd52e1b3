"""The configurations that come with hydrofdi, found by their names; a file of the user comes first."""

from __future__ import annotations

import difflib
import json
import os
import re
from functools import cache
from pathlib import Path
from typing import Any, Literal

from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import brief, nearest

_FOLDER = "configs"
_PACKAGE = Path(__file__).resolve().parents[1]
_PLACES = (_PACKAGE / _FOLDER, _PACKAGE.parent / _FOLDER)
"""Where they lie in an installed package, and in a clone of the repository."""

_SCHEMA_LINE = "# yaml-language-server:"
_REFERENCE = re.compile(r"[\w./-]+\.(?:yaml|csv)\b")
_SENTENCE = re.compile(r".*?[.?!](?=\s|$)")


def located(path: Path, folder: Path = Path()) -> Path:
    """The file that a path or name means."""
    here = folder / path
    for own in (here, Path(f"{here}.yaml")):
        if os.path.exists(own) and not os.path.isdir(own):
            return own
    return _ready(path) or here


def _ready(path: Path) -> Path | None:
    parts = path.parts[1:] if path.parts[:1] == (_FOLDER,) else path.parts
    if path.is_absolute() or not parts or ".." in parts:
        return None
    place = ready_folder().joinpath(*parts)
    found = (Path(f"{place}.yaml"), *([place] if place.suffix in (".yaml", ".csv") else []))
    return next((file for file in found if os.path.isfile(file)), None)


@cache
def ready_folder() -> Path:
    """Where the ready configurations lie."""
    return next((place for place in _PLACES if place.is_dir()), _PLACES[0])


def ready_names() -> list[str]:
    """Their names, such as ``table3`` and ``delays/smoke``; those in no group first."""
    folder = ready_folder()
    names = (file.relative_to(folder).with_suffix("").as_posix() for file in folder.rglob("*.yaml"))
    return sorted(names, key=lambda name: ("/" in name, name))


def ready_hint(path: Path) -> str:
    """A hint for a path that does not exist: the ready configuration that it probably means, if any."""
    asked = path.with_suffix("").as_posix().removeprefix(f"{_FOLDER}/")
    names = ready_names()
    same = [name for name in names if Path(name).name == Path(asked).name]
    close = same if len(same) == 1 else difflib.get_close_matches(asked, names, n=1, cutoff=0.7)
    if close:
        return f"; did you mean {close[0]!r}?"
    return "" if path.suffix else "; 'hydrofdi configs' lists the ready ones"


def ready_summary(name: str) -> str:
    """The first sentence of a ready configuration's first comment."""
    comment: list[str] = []
    for line in _lines(name):
        words = line.removeprefix("#").strip()
        if not line.startswith("#") or (comment and not words):
            break
        comment += [words] if words else []
    text = " ".join(comment)
    sentence = _SENTENCE.match(text)
    return sentence.group() if sentence else text


def ready_copy(name: str) -> str:
    """The text of a ready configuration for any folder: the files that it names are named as ready ones."""
    home = (ready_folder() / name).parent

    def named(found: re.Match[str]) -> str:
        file = Path(os.path.normpath(home / found.group()))
        return file.relative_to(ready_folder()).as_posix() if file.is_file() else found.group()

    return "\n".join(_REFERENCE.sub(named, line) for line in _lines(name)) + "\n"


def _lines(name: str) -> list[str]:
    """The lines of a ready configuration, without the line for editors."""
    lines = (ready_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if not line.startswith(_SCHEMA_LINE)]


def schema(
    kind: Literal["experiment", "measured", "monitor", "fleet", "detector"] = "experiment",
) -> dict[str, Any]:
    """The JSON Schema of a kind of file, as ``hydrofdi schema`` prints it.

    Raises
    ------
    ConfigError
        There is no such kind.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.schema("measured")["$schema"]
    'https://json-schema.org/draft/2020-12/schema'
    """
    known = ("experiment", "measured", "monitor", "fleet", "detector")
    if kind not in known:
        raise ConfigError(f"kind: {brief(kind)} is unknown{nearest(str(kind), known)}")
    file = ready_folder() / ("schema.json" if kind == "experiment" else f"{kind}-schema.json")
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found
