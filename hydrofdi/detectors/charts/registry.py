"""Registry of charts, found by the names of their modules."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from hydrofdi.detectors.charts import catalogue
from hydrofdi.detectors.charts.contract import Chart
from hydrofdi.errors import ConfigError
from hydrofdi.settings.messages import nearest


def chart_names() -> list[str]:
    """Names of all charts, sorted."""
    return sorted(module.name for module in iter_modules(catalogue.__path__))


def chart_kind(name: str) -> type[Chart[Any]]:
    """The class of a chart.

    Raises
    ------
    ConfigError
        There is no chart of this name.
    """
    if name not in chart_names():
        raise ConfigError(f"there is no chart {name!r}{nearest(name, chart_names())}")
    module = import_module(f"{catalogue.__name__}.{name}")
    (kind,) = (kind for kind in vars(module).values() if getattr(kind, "name", None) == name)
    found: type[Chart[Any]] = kind
    return found


def make_chart(name: str, options: Mapping[str, Any] | None = None) -> Chart[Any]:
    """Make a chart with options.

    Raises
    ------
    ConfigError
        There is no chart of this name.
    ValidationError
        The options are not valid.
    """
    kind = chart_kind(name)
    return kind(kind.Options.model_validate(dict(options or {})))
