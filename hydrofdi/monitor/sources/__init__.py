"""Where streams come from."""

from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource

__all__ = ["Position", "Reading", "StreamSource"]
