"""Trained detectors: what healthy records taught, kept in a file that a person can read."""

from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig, WindowConfig
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.verdict import Verdict

__all__ = ["ChartConfig", "DetectorConfig", "DetectorFile", "Verdict", "WindowConfig"]
