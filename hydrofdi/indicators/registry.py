"""All indicators: those of this package, and those that other packages add.

A package adds its own by an entry point in the group ``hydrofdi.indicators``::

    [project.entry-points."hydrofdi.indicators"]
    peak = "my_package:Peak"
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pkgutil import iter_modules
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import catalogue
from hydrofdi.indicators.contract import Indicator
from hydrofdi.settings.mistakes import nearest

GROUP = "hydrofdi.indicators"

Kind = type[Indicator[Any]]


def indicator_names() -> list[str]:
    """Names of all indicators, sorted."""
    return sorted({*_own_names(), *_added()})


@cache
def indicator_kind(name: str) -> Kind:
    """The class of an indicator.

    Raises
    ------
    ConfigError
        There is none of this name, or the package that adds it cannot be loaded.
    """
    if name in _own_names():
        return _own(name)
    if name in _added():
        return _load(_added()[name])
    raise ConfigError(f"there is no indicator {name!r}{nearest(name, indicator_names())}")


@cache
def _own_names() -> frozenset[str]:
    return frozenset(module.name for module in iter_modules(catalogue.__path__))


def _own(name: str) -> Kind:
    module = import_module(f"{catalogue.__name__}.{name}")
    kinds = [kind for kind in vars(module).values() if getattr(kind, "name", None) == name]
    (kind,) = (kind for kind in kinds if isinstance(kind, type))
    return kind


@cache
def _added() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


def _load(point: EntryPoint) -> Kind:
    try:
        kind: Kind = point.load()
    except Exception as error:
        raise ConfigError(f"indicator {point.name!r}: {point.value} cannot be loaded: {error}") from None
    if getattr(kind, "name", None) != point.name:
        raise ConfigError(f"indicator {point.name!r}: {point.value} is no indicator of this name")
    return kind
