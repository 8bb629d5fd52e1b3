"""Registry of charts, found by the names of their modules."""

from __future__ import annotations

from typing import Any

from hydrofdi.detectors.charts import catalogue
from hydrofdi.detectors.charts.contract import Chart
from hydrofdi.scoring.registry import Registry

_CHARTS: Registry[Chart[Any]] = Registry(catalogue, "chart")
chart_names, chart_kind, make_chart = _CHARTS.names, _CHARTS.kind, _CHARTS.make
