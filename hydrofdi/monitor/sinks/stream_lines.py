"""JSON lines on standard output."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TextIO

from hydrofdi.monitor.line_record import line_text
from hydrofdi.monitor.lines import Event, Line
from hydrofdi.records.streams import Chunk


class StreamLines:
    """Writes each line as JSON, except silent ones, and flushes after each step.

    Parameters
    ----------
    stream : file object
        Standard output.
    unit : str
                Unit of scores.
    """

    def __init__(self, stream: TextIO, unit: str = "1") -> None:
        self._stream, self._unit = stream, unit

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Write lines.

        Raises
        ------
        BrokenPipeError
            Nobody reads the output any more.
        """
        if text := lines_text(lines, self._unit):
            self._stream.write(text)
            self._stream.flush()
        return ()

    def close(self) -> None:
        """Do nothing: all lines are written."""


def lines_text(lines: Sequence[Line], unit: str) -> str:
    """All lines except silent ones, as lines of JSON."""
    said = (line for line in lines if not (isinstance(line, Event) and line.is_silent))
    return "".join(line_text(line, unit) for line in said)
