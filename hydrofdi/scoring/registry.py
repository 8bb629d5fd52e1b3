"""Registry of scores, found by the names of their modules."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.scoring import catalogue
from hydrofdi.scoring.contract import Score
from hydrofdi.settings.messages import nearest


def score_names() -> list[str]:
    """Names of all scores, sorted."""
    return sorted(module.name for module in iter_modules(catalogue.__path__))


def score_kind(name: str) -> type[Score[Any]]:
    """The class of a score.

    Raises
    ------
    ConfigError
        There is no score of this name.
    """
    if name not in score_names():
        raise ConfigError(f"there is no score {name!r}{nearest(name, score_names())}")
    module = import_module(f"{catalogue.__name__}.{name}")
    (kind,) = (kind for kind in vars(module).values() if getattr(kind, "name", None) == name)
    found: type[Score[Any]] = kind
    return found


def make_score(name: str, options: Mapping[str, Any] | None = None) -> Score[Any]:
    """Make a score with options.

    Raises
    ------
    ConfigError
        There is no score of this name.
    ValidationError
        The options are not valid.
    """
    kind = score_kind(name)
    return kind(kind.Options.model_validate(dict(options or {})))
