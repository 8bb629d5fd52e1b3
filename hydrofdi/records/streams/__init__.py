"""Streams: samples as they come, checked and cut into windows, which do not depend on the chunks."""

from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.window import Window, WindowFault

__all__ = ["Chunk", "State", "Window", "WindowFault"]
