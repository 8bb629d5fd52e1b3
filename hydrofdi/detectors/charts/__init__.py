"""Control charts on the time trace of a score.

A chart knows standardised scores (healthy ones have median 0 and spread 1) and neither their interval nor
what they were measured of. An alarm is a statistic that reaches the limit.
"""

from hydrofdi.detectors.charts.contract import Chart, ChartOptions, State
from hydrofdi.detectors.charts.registry import chart_kind, chart_names, make_chart

__all__ = ["Chart", "ChartOptions", "State", "chart_kind", "chart_names", "make_chart"]
