"""What takes lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from hydrofdi.monitor.lines import Line
from hydrofdi.records.streams import Chunk


class Sink(Protocol):
    """Something that takes lines: standard output, a log, a broker, a web address, metrics, a view.

    A sink that may be slow keeps a bounded queue of its own and never holds the monitor up; only standard
    output and the log may.
    """

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take the samples of a reading and the lines that came of it; gives what it has to say itself."""
        ...

    def close(self) -> None:
        """Send what is left, for a few seconds at most, and end."""
        ...
