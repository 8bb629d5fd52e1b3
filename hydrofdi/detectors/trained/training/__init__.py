"""Training of detectors on healthy records."""

from hydrofdi.detectors.trained.training.making import train
from hydrofdi.detectors.trained.training.stating import stated_detector

__all__ = ["stated_detector", "train"]
