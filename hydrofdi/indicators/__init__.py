"""Indicators: quantities computed from records that may change with leakage. They see only records."""

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.measuring import Measures, measure
from hydrofdi.indicators.registry import indicator_kind, indicator_names
from hydrofdi.indicators.selection import indicators_of, make_indicators

__all__ = [
    "Indicator",
    "Measures",
    "Output",
    "indicator_kind",
    "indicator_names",
    "indicators_of",
    "make_indicators",
    "measure",
]
