"""Detectors: trained on healthy records, they score other records, as batches or as streams."""

from hydrofdi.detectors.contract import Detector, OnlineDetector
from hydrofdi.detectors.distance_detector import DistanceDetector
from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.healthy_scale import HealthyScale, healthy_scale
from hydrofdi.detectors.indicator_detector import IndicatorDetector
from hydrofdi.detectors.recursive_detector import RecursiveDetector

__all__ = [
    "Detector",
    "DistanceDetector",
    "Feature",
    "HealthyScale",
    "IndicatorDetector",
    "OnlineDetector",
    "RecursiveDetector",
    "healthy_scale",
]
