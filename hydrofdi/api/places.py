"""Paths and optional libraries."""

from __future__ import annotations

from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError, ReportError
from hydrofdi.settings.counting import brief


def path_of(place: Any) -> Path:
    """A path, with ``~`` as the home of the user; for stored results, their folder.

    Raises
    ------
    ConfigError
        The value has another type.
    """
    place = getattr(place, "folder", place)
    if not isinstance(place, str | PathLike):
        raise ConfigError(f"expected a path, found {brief(place)}")
    return Path(place).expanduser()


def notebook_library(name: str) -> Any:
    """A library of the extra ``notebook``.

    Raises
    ------
    ReportError
        It is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise ReportError(f"{name} is not installed: pip install 'hydrofdi[notebook]'") from None
