"""A log of lines that has each window once, even after a crash."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.monitor.lines import Line
from hydrofdi.monitor.sinks.stream_lines import lines_text
from hydrofdi.store.files import reason

LARGEST_BACKLOG = 16 * 2**20
"""Bytes of lines that wait in memory while the disk is full."""


class WindowLog:
    """JSON lines in a file. The state file keeps its length, so that what came behind it is cut off again.

    The file is opened anew for each step: it may be rotated at any moment.

    Parameters
    ----------
    path : Path
    unit : str
        Of scores.
    """

    def __init__(self, path: Path, unit: str = "1") -> None:
        self.path, self._unit = path, unit
        self._waiting = b""

    def open(self, length: int | None) -> None:
        """Go on behind the first `length` bytes, or behind all that there is; a shorter file is a new one.

        Raises
        ------
        StoreError
            It cannot be written.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with open(self.path, "ab") as file:
                if length is not None and length < file.tell():
                    file.truncate(length)
        except OSError as error:
            raise self._refused(error) from None

    def append(self, lines: Sequence[Line]) -> int:
        """Add lines and make them survive a crash of the machine; gives the length of the file [bytes].

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
        try:
            with open(self.path, "ab", buffering=0) as file:
                length = file.tell()
                if self._waiting:
                    self._write(file.fileno(), length)
                return length + self._pop()
        except OSError as error:
            raise self._refused(error) from None

    def _write(self, descriptor: int, length: int) -> None:
        """All that waits, or nothing."""
        try:
            written = 0
            while written < len(self._waiting):
                written += os.write(descriptor, self._waiting[written:])
            os.fsync(descriptor)
        except OSError:
            os.ftruncate(descriptor, length)
            raise

    def _pop(self) -> int:
        n_byte, self._waiting = len(self._waiting), b""
        return n_byte

    def _refused(self, error: OSError) -> StoreError:
        return StoreError(f"{self.path}: cannot be written: {reason(error)}")
