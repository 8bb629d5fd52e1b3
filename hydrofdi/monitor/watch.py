"""Lines of a stream: pure, with a state of arrays."""

from __future__ import annotations

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.monitor.lines import Line
from hydrofdi.records.streams import Chunk, State


class Watch:
    """Samples go in, lines come out. The lines of a stream do not depend on its chunks.

    Parameters
    ----------
    file : DetectorFile
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file

    def start(self) -> State:
        """The state before the first sample."""
        raise NotImplementedError

    def resume(self, state: State) -> State:
        """A stored state, fit to go on: samples that come again are left out in silence."""
        raise NotImplementedError

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Line]]:
        """The state behind a chunk, and what is to be said of it; the old state stays as it was."""
        raise NotImplementedError

    def end(self, state: State) -> tuple[State, list[Line]]:
        """What is to be said when a stream is over."""
        raise NotImplementedError

    def next_number(self, state: State) -> int:
        """Number of the next window."""
        raise NotImplementedError
