"""Streams: samples are checked as they come and cut into windows, which do not depend on the chunks."""

from hydrofdi.errors import Issue
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.even import EvenStream
from hydrofdi.records.streams.findings import Finding
from hydrofdi.records.streams.window import Window
from hydrofdi.records.streams.windower import Windower
from hydrofdi.records.streams.windowing import make_windower, windows_of

__all__ = [
    "Chunk",
    "EvenStream",
    "Finding",
    "Issue",
    "State",
    "Window",
    "Windower",
    "make_windower",
    "windows_of",
]
