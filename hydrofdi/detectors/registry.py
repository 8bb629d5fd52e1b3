"""Scores and charts, found by the names of their modules."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, Generic, TypeVar

from hydrofdi.detectors.charts import catalogue as charts
from hydrofdi.detectors.charts.contract import Chart
from hydrofdi.detectors.scores import catalogue as scores
from hydrofdi.detectors.scores.contract import Score
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import nearest

Made = TypeVar("Made")


class Registry(Generic[Made]):
    """Classes with a ``name`` and ``Options`` in a package whose modules have these names."""

    def __init__(self, package: ModuleType, noun: str) -> None:
        self._package, self._noun = package, noun

    def names(self) -> list[str]:
        """All names, sorted."""
        return sorted(module.name for module in iter_modules(self._package.__path__))

    def kind(self, name: str) -> Any:
        """The class of a name.

        Raises
        ------
        ConfigError
            There is none.
        """
        if name not in self.names():
            raise ConfigError(f"there is no {self._noun} {name!r}{nearest(name, self.names())}")
        module = import_module(f"{self._package.__name__}.{name}")
        (kind,) = (kind for kind in vars(module).values() if getattr(kind, "name", None) == name)
        return kind

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> Made:
        """An instance with options.

        Raises
        ------
        ConfigError
            There is no such name.
        ValidationError
            The options are not valid.
        """
        kind = self.kind(name)
        made: Made = kind(kind.Options.model_validate(dict(options or {})))
        return made


_SCORES: Registry[Score[Any]] = Registry(scores, "score")
score_names, score_kind, make_score = _SCORES.names, _SCORES.kind, _SCORES.make

_CHARTS: Registry[Chart[Any]] = Registry(charts, "chart")
chart_names, chart_kind, make_chart = _CHARTS.names, _CHARTS.kind, _CHARTS.make
