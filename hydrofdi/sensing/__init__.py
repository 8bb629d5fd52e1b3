"""Sensor models: from simulated to measured signals."""

from hydrofdi.sensing.measurement import Measurement, quantisation_noise
from hydrofdi.sensing.noise import CHANNELS, Channel, noise_autocovariance

__all__ = ["CHANNELS", "Channel", "Measurement", "noise_autocovariance", "quantisation_noise"]
