"""The contract of sinks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from hydrofdi.monitor.lines import Line
from hydrofdi.records.streams import Chunk


class Sink(Protocol):
    """A receiver of lines: standard output, a log, a broker, a web address, metrics, a view.

    A sink that may be slow has a bounded queue of its own and never blocks the monitor; only standard output
    and the log may block it.
    """

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take the samples and the lines of a reading; return the sink's own events."""
        ...

    def close(self) -> None:
        """Send what is left, within a few seconds, and end."""
        ...
