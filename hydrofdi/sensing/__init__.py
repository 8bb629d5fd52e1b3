"""What sensors make of the simulated signals."""

from hydrofdi.sensing.channels import CHANNELS, Channel
from hydrofdi.sensing.conversion import white_noise
from hydrofdi.sensing.measurement import Measurement

__all__ = ["CHANNELS", "Channel", "Measurement", "white_noise"]
