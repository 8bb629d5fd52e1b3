"""Trained detectors: training results of healthy records, stored in a readable file."""

from hydrofdi.detectors.trained.charting import ChartReading, ScoreChart, chart_of
from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig, WindowConfig
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.following import Follower
from hydrofdi.detectors.trained.judging import Judge
from hydrofdi.detectors.trained.verdict import Verdict

__all__ = [
    "ChartConfig",
    "ChartReading",
    "DetectorConfig",
    "DetectorFile",
    "Follower",
    "Judge",
    "ScoreChart",
    "Verdict",
    "WindowConfig",
    "chart_of",
]
