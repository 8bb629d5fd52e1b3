"""Sinks of lines."""

from hydrofdi.monitor.sinks.contract import Sink

__all__ = ["Sink"]
