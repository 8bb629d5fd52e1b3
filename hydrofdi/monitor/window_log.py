"""A log that has each window once."""

from __future__ import annotations

import io
import os
from itertools import takewhile
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.monitor.growing_file import found_again, place_in
from hydrofdi.monitor.sources import Position
from hydrofdi.store.files import open_own, reason, write_all
from hydrofdi.store.folder import take_lock

_OWN = b'{"line": "'

LARGEST_BACKLOG = 16 * 2**20
"""Most bytes of lines that wait in memory while the disk is full."""


class WindowLog:
    """JSON lines in a file that no other monitor writes meanwhile.

    The state stores the lines of a step and their place before they are written, so that a restart
    writes those that are not there. If the file is renamed, the next step begins a new one.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._waiting = b""
        self._file: io.FileIO | None = None

    def open(self, position: Position) -> None:
        """Continue at the end of the file, with the lines of a stored position that were not written."""
        file = self._opened()
        try:
            self._waiting = _unwritten(position, file) if position else b""
        except OSError as error:
            raise self._refused(error) from None

    @property
    def position(self) -> Position:
        """Waiting lines, and their place: path and end of the file."""
        file = self._opened()
        place = place_in(file.fileno(), os.fstat(file.fileno()).st_size)
        return {"path": str(self.path.resolve()), "waiting": self._waiting.decode(), **place}

    def take(self, text: str) -> None:
        """Let lines of JSON wait."""
        self._waiting += text.encode()
        if len(self._waiting) > LARGEST_BACKLOG:
            self._waiting = self._waiting[
                self._waiting.index(b"\n", len(self._waiting) - LARGEST_BACKLOG) + 1 :
            ]

    @property
    def has_waiting(self) -> bool:
        """Whether lines wait."""
        return bool(self._waiting)

    def write(self) -> None:
        """Write all waiting lines, or none, at `position`, and make them survive a crash of the machine."""
        if not self._waiting:
            return
        file = self._file
        assert file is not None
        length = os.fstat(file.fileno()).st_size
        try:
            try:
                write_all(file, self._waiting)
                os.fsync(file.fileno())
            except OSError:
                file.truncate(length)
                raise
        except OSError as error:
            raise self._refused(error) from None
        self._waiting = b""

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _opened(self) -> io.FileIO:
        """The file that has the name now, locked."""
        if self._file is None or not self._has_name(self._file):
            self.close()
            self._file = open_own(self.path, _OWN, "a log of a monitor")
            take_lock(self._file, f"{self.path}: another monitor writes it")
        return self._file

    def _has_name(self, file: io.FileIO) -> bool:
        try:
            return os.path.samestat(self.path.stat(), os.fstat(file.fileno()))
        except OSError:
            return False

    def _refused(self, error: OSError) -> StoreError:
        return StoreError(f"{self.path}: cannot be written: {reason(error)}")


def _unwritten(position: Position, log: io.FileIO) -> bytes:
    """The waiting lines of a stored position that are not in its file, also if that was renamed since.

    Of a file that is gone or was cut, all are taken as written. A torn line at the end of `log` is cut off.
    """
    waiting: bytes = position["waiting"].encode()
    file = found_again(Path(position["path"]), position)
    if file is None:
        return b""
    tail, is_log = file.read(len(waiting) + 1), os.path.samestat(file.status, os.fstat(log.fileno()))
    file.close()
    pairs = zip(tail.splitlines(True), waiting.splitlines(True), strict=False)
    n_written = sum(len(line) for line, _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
    if waiting.startswith(tail) and is_log:
        log.truncate(int(position["offset"]) + n_written)
    return waiting[n_written:]
