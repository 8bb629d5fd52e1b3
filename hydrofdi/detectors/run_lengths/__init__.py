"""Run lengths of charts: time to a false alarm, and delay from the onset of a leak to the alarm."""

from hydrofdi.detectors.run_lengths.delays import Delay, Delays, delays
from hydrofdi.detectors.run_lengths.false_alarms import AlarmLimit, FalseAlarms

__all__ = ["AlarmLimit", "Delay", "Delays", "FalseAlarms", "delays"]
