"""Checks of arguments; an error names the argument."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import brief
from hydrofdi.units import parse_quantity, stated_unit

Names = str | Mapping[str, str] | None
"""One name for all columns, or column → name."""
Texts = str | Sequence[str] | None
"""One text for all records, or one for each."""


def refusal(name: str, expected: str, found: object) -> ConfigError:
    """The error for an argument of a wrong type."""
    return ConfigError(f"{name}: expected {expected}; found {brief(found)}")


def number_of(name: str, given: Any, unit: str, expected: str, *, needs_unit: bool = False) -> float:
    """A number, with a unit or in SI; with `needs_unit`, a text has one."""
    if isinstance(given, bool) or not isinstance(given, str | Real):
        raise refusal(name, expected, given)
    try:
        value = parse_quantity(given, unit) if isinstance(given, str) else float(given)
        if needs_unit and isinstance(given, str) and unit != "1" and stated_unit(given, unit) is None:
            raise ValueError(f"{given!r} has no unit, such as 'L/min'")
    except ValueError as error:
        raise ConfigError(f"{name}: {error}") from None
    return value


def positive_of(name: str, given: Any, unit: str, expected: str) -> float:
    """A finite number above zero, with a unit or in SI."""
    value = number_of(name, given, unit, expected)
    if not 0.0 < value < math.inf:
        raise ConfigError(f"{name}: must be above zero; found {given!r}")
    return value


def count_of(name: str, given: Any) -> int:
    """An integer from 1."""
    if isinstance(given, bool) or not isinstance(given, Integral):
        raise refusal(name, "an integer", given)
    if given < 1:
        raise ConfigError(f"{name}: must be at least 1; found {given}")
    return int(given)


def names_of(name: str, given: Any, expected: str) -> list[str]:
    """Names or numbers, one or several, as texts."""
    several = [given] if isinstance(given, str | Integral) or not isinstance(given, Iterable) else [*given]
    if any(isinstance(each, bool) or not isinstance(each, str | Integral) for each in several):
        raise refusal(name, expected, given)
    return [str(each) for each in several]


def path_of(place: Any) -> Path:
    """A path, with ``~`` as the home of the user; for stored results, their folder."""
    place = getattr(place, "folder", place)
    if not isinstance(place, str | PathLike):
        raise ConfigError(f"expected a path, found {brief(place)}")
    return Path(place).expanduser()
