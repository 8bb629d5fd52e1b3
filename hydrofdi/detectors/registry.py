"""Scores and charts, found by the names of their classes."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import nearest

if TYPE_CHECKING:
    from hydrofdi.detectors.charts import Chart
    from hydrofdi.detectors.scores.contract import Score

Made = TypeVar("Made")


class Registry(Generic[Made]):
    """Classes of a module with a ``name`` and ``Options``."""

    def __init__(self, module: str, noun: str) -> None:
        self._module, self._noun = module, noun

    @cached_property
    def _kinds(self) -> dict[str, Any]:
        """Name → class; the module is loaded when it is needed, as kernels take time to load."""
        module = import_module(f"hydrofdi.detectors.{self._module}")
        classes: list[Any] = [each for each in vars(module).values() if isinstance(each, type)]
        return {each.name: each for each in classes if "name" in vars(each)}

    def names(self) -> list[str]:
        """All names, sorted."""
        return sorted(self._kinds)

    def kind(self, name: str) -> Any:
        """The class of a name."""
        if name not in self._kinds:
            raise ConfigError(f"there is no {self._noun} {name!r}{nearest(name, self.names())}")
        return self._kinds[name]

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> Made:
        """An instance with options."""
        kind = self.kind(name)
        made: Made = kind(kind.Options.model_validate(dict(options or {})))
        return made


_SCORES: Registry[Score[Any]] = Registry("scores.catalogue", "score")
score_names, score_kind, make_score = _SCORES.names, _SCORES.kind, _SCORES.make

_CHARTS: Registry[Chart[Any]] = Registry("charts", "chart")
chart_names, chart_kind, make_chart = _CHARTS.names, _CHARTS.kind, _CHARTS.make
