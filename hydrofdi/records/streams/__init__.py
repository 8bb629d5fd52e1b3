"""Streams: samples are checked as they come and cut into windows, which do not depend on the chunks."""

from hydrofdi.errors import Issue
from hydrofdi.records.streams.checks import Chunk, EvenStream, Finding, State, Window
from hydrofdi.records.streams.windows import Windower, make_windower, windows_of

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
