"""What sensors make of the simulated signals."""

from hydrofdi.sensing.conversion import white_noise
from hydrofdi.sensing.measurement import CHANNELS, Channel, measure

__all__ = ["CHANNELS", "Channel", "measure", "white_noise"]
