"""Sources of streams."""

from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource

__all__ = ["Position", "Reading", "StreamSource"]
