"""A file that is distinguished from others of its name: it is found again after a rename."""

from __future__ import annotations

import os
from glob import escape
from hashlib import sha256
from pathlib import Path
from typing import Any

from hydrofdi.monitor.sources.contract import Position

_HEAD = 256
"""Bytes at the beginning that tell a file from a later one with the same inode."""


class FollowedFile:
    """An open file.

    Parameters
    ----------
    path : path
    offset : int
        Where to begin to read.

    Attributes
    ----------
    offset : int
        Where the next byte is read.

    Raises
    ------
    OSError
        It cannot be opened.
    """

    def __init__(self, path: Path, offset: int = 0) -> None:
        self._file = open(path, "rb", buffering=0)  # noqa: SIM115
        self._head = self._file.read(min(_HEAD, offset))
        self.inode = os.fstat(self._file.fileno()).st_ino
        self._file.seek(offset)
        self.offset = offset

    def read(self, n_byte: int) -> bytes:
        """What follows; nothing at the end."""
        data = self._file.read(n_byte)
        self.offset += len(data)
        if len(self._head) < _HEAD:
            self._head = (self._head + data)[:_HEAD]
        return data

    def position(self, n_unfinished: int) -> dict[str, Any]:
        """Where the unfinished line begins."""
        offset = self.offset - n_unfinished
        return {"inode": self.inode, "offset": offset, "head": _digest(self._head[:offset])}

    def was_truncated(self) -> bool:
        """Whether it ends before what was read."""
        return os.fstat(self._file.fileno()).st_size < self.offset

    def begin_anew(self) -> None:
        """Read from the beginning."""
        self._file.seek(0)
        self.offset, self._head = 0, b""

    @property
    def modified(self) -> int:
        """When it was written last [ns]."""
        return os.fstat(self._file.fileno()).st_mtime_ns

    def is_at(self, position: Position) -> bool:
        """Whether it still begins as it did when a position was stored, and goes as far."""
        offset = int(position["offset"])
        is_long = os.fstat(self._file.fileno()).st_size >= offset
        return is_long and _digest(self._head[:offset]) == position["head"]

    def close(self) -> None:
        """End reading."""
        self._file.close()


def found_again(path: Path, position: Position) -> FollowedFile | None:
    """The file of a stored position, under its name or another one beside it; None if it is gone.

    Raises
    ------
    OSError
        The folder cannot be read.
    """
    for candidate in (path, *sorted(path.parent.iterdir())):
        if not candidate.is_file() or candidate.stat().st_ino != position["inode"]:
            continue
        file = FollowedFile(candidate, int(position["offset"]))
        if file.is_at(position):
            return file
        file.close()
    return None


def following(path: Path, file: FollowedFile) -> Path:
    """The file that was begun after one was renamed: another one that was renamed since, or that of the name.

    Renamed files are those beside it whose names begin with its name, as logrotate calls them.

    Raises
    ------
    OSError
        The folder cannot be read.
    """
    later = [
        (found.stat().st_mtime_ns, found)
        for found in path.parent.glob(f"{escape(path.name)}?*")
        if found.suffix.lower() != ".gz" and found.is_file() and found.stat().st_ino != file.inode
    ]
    return min([each for each in later if each[0] > file.modified], default=(0, path))[1]


def _digest(head: bytes) -> str:
    return sha256(head).hexdigest()[:16]
