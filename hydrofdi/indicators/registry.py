"""Registry of indicators, built-in ones and those of other packages, and their descriptions.

A package adds indicators by entry points in the group ``hydrofdi.indicators``::

    [project.entry-points."hydrofdi.indicators"]
    peak = "my_package:Peak"
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pkgutil import iter_modules
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import catalogue, models
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.faults import made_soundly
from hydrofdi.records import Channel
from hydrofdi.settings.messages import nearest, shown_quantity
from hydrofdi.settings.quantities import field_quantity, field_texts

GROUP = "hydrofdi.indicators"

_DECLARED = ("version", "summary", "source", "Options", "channels", "outputs", "measure")
"""Attributes that every indicator must declare."""

Kind = type[Indicator[Any]]

FROM_FILES: dict[str, Kind] = {}
"""Name with hash → indicator of a file that an experiment named in this process."""


def indicator_names() -> list[str]:
    """Names of all indicators, sorted."""
    return sorted({*_homes(), *_added()})


@cache
def indicator_kind(name: str) -> Kind:
    """The class of an indicator.

    Raises
    ------
    ConfigError
        There is no indicator of this name, or the package that adds it cannot be loaded.
    """
    if name in FROM_FILES:
        return FROM_FILES[name]
    if name in _homes():
        return _own(name)
    if name in _added():
        return _load(_added()[name])
    raise ConfigError(f"there is no indicator {name!r}{nearest(name, indicator_names())}")


def sound_indicator(name: str, options: Mapping[str, Any] | None = None) -> Indicator[Any]:
    """Make an indicator with options, and check its declaration."""
    kind = indicator_kind(name)
    chosen = kind.Options.model_validate(dict(options or {}))
    return made_soundly(kind, name, chosen)


@cache
def _homes() -> dict[str, str]:
    """Name of a built-in indicator → its package."""
    return {
        module.name: room.__name__ for room in (catalogue, models) for module in iter_modules(room.__path__)
    }


def _own(name: str) -> Kind:
    module = import_module(f"{_homes()[name]}.{name}")
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
    if not isinstance(kind, type) or getattr(kind, "name", None) != point.name:
        raise ConfigError(f"indicator {point.name!r}: {point.value} is not an indicator of this name")
    require_declared(kind, point.value)
    return kind


def require_declared(kind: Kind, place: str) -> None:
    """Check that an indicator has all that it must declare."""
    missing = [part for part in _DECLARED if not hasattr(kind, part)]
    if missing or not isinstance(kind.version, int):
        fault = f"has no {' and no '.join(missing)}" if missing else "has a version that is not an integer"
        raise ConfigError(f"indicator {kind.name!r}: {place} {fault}")


@dataclass(frozen=True)
class Option:
    """An option of an indicator.

    Attributes
    ----------
    default : str
        With a unit that suits it, as a configuration may state it; ``–`` if there is none.
    unit : str
        SI; ``1`` for dimensionless numbers, empty if the option is not a quantity.
    text : str
        Description.
    """

    name: str
    default: str
    unit: str
    text: str


@dataclass(frozen=True)
class Description:
    """An indicator with its default outputs and channels."""

    name: str
    version: int
    summary: str
    source: str
    equation: str
    caution: str
    is_cheap: bool
    needs_scale: bool
    channels: tuple[Channel, ...]
    optional_channels: tuple[Channel, ...]
    outputs: tuple[Output, ...]
    options: tuple[Option, ...]

    @property
    def cost(self) -> str:
        """Cost class, for tables."""
        return "cheap" if self.is_cheap else "costly"


def describe(name: str) -> Description:
    """Describe an indicator."""
    kind = indicator_kind(name)
    indicator, texts = sound_indicator(name), field_texts(kind.Options)
    options = []
    for field, info in kind.Options.model_fields.items():
        quantity, default = field_quantity(info), info.get_default(call_default_factory=True)
        unit = quantity.unit if quantity else ""
        options.append(Option(field, _shown(default, unit), unit, " ".join(texts.get(field, "").split())))
    return Description(
        name, kind.version, kind.summary, kind.source, kind.equation, kind.caution, kind.is_cheap,
        kind.needs_scale,
        tuple(sorted(indicator.channels)), tuple(sorted(indicator.optional_channels)),
        tuple(indicator.outputs), tuple(options),
    )  # fmt: skip


def _shown(value: Any, unit: str) -> str:
    if value is None or value in ((), [], {}):
        return "–"
    if isinstance(value, tuple | list):
        return ", ".join(_shown(item, unit) for item in value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, float):
        return shown_quantity(value, unit or "1")
    return str(value)
