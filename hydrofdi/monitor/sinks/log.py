"""A log of lines that has each window once, even after a crash."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.monitor.lines import Line
from hydrofdi.monitor.sinks.stream_lines import lines_text
from hydrofdi.monitor.sources import Position
from hydrofdi.store.files import reason, require_regular

LARGEST_BACKLOG = 16 * 2**20
"""Most bytes of lines that wait in memory while the disk is full."""


class WindowLog:
    """JSON lines in a file. The state file stores its length; a restart cuts off later lines.

    The file is opened anew for each step: it may be rotated at any moment.

    Parameters
    ----------
    path : Path
    unit : str
                Unit of scores.
    """

    def __init__(self, path: Path, unit: str = "1") -> None:
        self.path, self._unit = path, unit
        self._waiting = b""

    def open(self, position: Position) -> None:
        """Continue at a stored position; at the end of the file if the position is that of another file.

        A shorter file was rotated: its lines are elsewhere.

        Raises
        ------
        StoreError
            It is not a regular file, or cannot be written.
        """
        require_regular(self.path)
        is_same = position.get("path") == str(self.path.resolve())
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with open(self.path, "ab") as file:
                if is_same and position["length"] < file.tell():
                    file.truncate(position["length"])
        except OSError as error:
            raise self._refused(error) from None

    @property
    def position(self) -> Position:
        """The position after all lines: path and length of the file [bytes], 0 if it was rotated away."""
        length = self.path.stat().st_size if self.path.exists() else 0
        return {"path": str(self.path.resolve()), "length": length}

    def append(self, lines: Sequence[Line]) -> None:
        """Add lines and make them survive a crash of the machine.

        Lines that cannot be written wait for the next call.

        Raises
        ------
        StoreError
            The disk is full, or the file cannot be written.
        """
        self._waiting += lines_text(lines, self._unit).encode()
        if len(self._waiting) > LARGEST_BACKLOG:
            self._waiting = self._waiting[
                self._waiting.index(b"\n", len(self._waiting) - LARGEST_BACKLOG) + 1 :
            ]
        if not self._waiting:
            return
        try:
            with open(self.path, "ab", buffering=0) as file:
                self._write(file.fileno(), file.tell())
        except OSError as error:
            raise self._refused(error) from None
        self._waiting = b""

    def _write(self, descriptor: int, length: int) -> None:
        """Write all waiting lines, or none."""
        try:
            written = 0
            while written < len(self._waiting):
                written += os.write(descriptor, self._waiting[written:])
            os.fsync(descriptor)
        except OSError:
            os.ftruncate(descriptor, length)
            raise

    def _refused(self, error: OSError) -> StoreError:
        return StoreError(f"{self.path}: cannot be written: {reason(error)}")
