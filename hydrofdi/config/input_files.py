"""CSV files that an experiment names, read into its data before it is validated."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

from hydrofdi.config.sections.csv_input import CsvError, held_text, read_csv_input
from hydrofdi.errors import Issue
from hydrofdi.settings.ready import located
from hydrofdi.settings.yaml_source import Path, Source, dotted

_STAND_IN = "# unreadable\ntime [s],voltage [V]\n0.0,0.0\n"
"""Placeholder for a file with mistakes, so that they are listed once."""


def anchor_input_files(source: Source, folder: FilePath) -> None:
    """Make the paths of input files start from the folder of the file that names them."""
    for container, key, _ in list(_places(source.data, ())):
        if _is_path(container[key]):
            container[key] = str(located(FilePath(container[key]), folder))


def read_input_files(source: Source) -> None:
    """Replace the paths of input files by the files' contents; mistakes are collected."""
    for container, key, path in list(_places(source.data, ())):
        value = container[key]
        try:
            container[key] = read_csv_input(FilePath(value)) if _is_path(value) else _same(value)
        except CsvError as error:
            container[key] = _STAND_IN
            source.mistakes += [_mistake(source, path, value, *mistake) for mistake in error.mistakes]


def _same(text: str) -> str:
    """Contents that stand in the experiment file itself, or come from a stored one."""
    first = text.partition("\n")[0]
    return held_text(first.removeprefix("# ") if first.startswith("# ") else "text", text)


def _mistake(source: Source, path: Path, value: str, line: int, message: str) -> Issue:
    if not _is_path(value):
        return source.mistake(path, f"line {line}: {message}" if line else message)
    if line:
        return Issue(message, dotted(path), f"{value}:{line}")
    return source.mistake(path, f"{value}: {message}")


def _is_path(text: str) -> bool:
    return "\n" not in text


def _places(data: Any, path: Path) -> Iterator[tuple[Any, Any, Path]]:
    """Where the data name an input file: container, key or index, and path."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        here = (*path, key)
        if here == ("input", "file") or key == "input.file":
            yield from _texts(data, key, here)
        else:
            yield from _places(value, here)


def _texts(container: Any, key: Any, path: Path) -> Iterator[tuple[Any, Any, Path]]:
    value = container[key]
    if isinstance(value, str):
        yield container, key, path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for inner, _ in items:
        yield from _texts(value, inner, (*path, inner))
