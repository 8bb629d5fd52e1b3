"""Paths."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError
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
