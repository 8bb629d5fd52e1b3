"""Run lengths: how long a chart runs until it raises an alarm, while healthy and after a leak sets in."""

from hydrofdi.detectors.run_lengths.delays import Delay, Delays, delays
from hydrofdi.detectors.run_lengths.false_alarms import AlarmLimit, FalseAlarms

__all__ = ["AlarmLimit", "Delay", "Delays", "FalseAlarms", "delays"]
