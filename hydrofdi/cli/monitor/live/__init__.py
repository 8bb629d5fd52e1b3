"""The live view of a stream on a terminal."""

from hydrofdi.cli.monitor.live.view import LiveView

__all__ = ["LiveView"]
