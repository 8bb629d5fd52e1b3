"""Training: healthy records go in, the file of a detector comes out."""

from hydrofdi.detectors.trained.training.making import train
from hydrofdi.detectors.trained.training.stating import stated_detector

__all__ = ["stated_detector", "train"]
