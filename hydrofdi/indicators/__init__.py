"""Indicators: quantities computed from records that may change with leakage. They see only records."""

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.measuring import Measures, measure
from hydrofdi.indicators.registry import indicator_kind, indicator_names
from hydrofdi.indicators.selection import load_indicators, make_indicators

__all__ = [
    "Indicator",
    "Measures",
    "Output",
    "indicator_kind",
    "indicator_names",
    "load_indicators",
    "make_indicators",
    "measure",
]
