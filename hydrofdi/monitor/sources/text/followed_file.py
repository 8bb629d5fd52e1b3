"""A file that is found again after it is renamed."""

from __future__ import annotations

import os
from glob import escape
from hashlib import sha256
from pathlib import Path
from typing import Any

from hydrofdi.monitor.sources.contract import Position

_HEAD = 4096
"""Bytes at the beginning that distinguish a file from a later one with the same inode."""


class FollowedFile:
    """An open file.

    Parameters
    ----------
    path : path
    offset : int
                Byte at which reading begins.

    Attributes
    ----------
    offset : int
                Position of the next byte.

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
        """The next bytes; empty at the end."""
        data = self._file.read(n_byte)
        self.offset += len(data)
        if len(self._head) < _HEAD:
            self._head = (self._head + data)[:_HEAD]
        return data

    def position(self, n_unfinished: int) -> dict[str, Any]:
        """The position of the unfinished line."""
        offset = self.offset - n_unfinished
        return {"inode": self.inode, "offset": offset, "head": _digest(self._head[:offset])}

    def was_truncated(self) -> bool:
        """Whether the file is now shorter than what was read."""
        return os.fstat(self._file.fileno()).st_size < self.offset

    def was_begun_anew(self) -> bool:
        """Whether it begins otherwise than what was read; a hole is what a writer leaves that went on."""
        head = os.pread(self._file.fileno(), len(self._head), 0)
        return not head.startswith(b"\0") and not self._head.startswith(head)

    def begin_anew(self) -> None:
        """Read from the beginning."""
        self._file.seek(0)
        self.offset, self._head = 0, b""

    @property
    def modified(self) -> int:
        """Time of the last write [ns]."""
        return os.fstat(self._file.fileno()).st_mtime_ns

    def is_at(self, position: Position) -> bool:
        """Whether it begins like the file of a stored position, and is long enough."""
        offset = int(position["offset"])
        is_long = os.fstat(self._file.fileno()).st_size >= offset
        return is_long and _digest(self._head[:offset]) == position["head"]

    def close(self) -> None:
        """Close the file."""
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
    """The file that was begun after `file` was renamed: a file that was renamed later, or the one at `path`.

    Renamed files are those in the folder of `path` whose names begin with its name, as with logrotate.

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


def place_in(descriptor: int, offset: int) -> dict[str, Any]:
    """The position of a byte in an open file."""
    head = os.pread(descriptor, min(_HEAD, offset), 0)
    return {"inode": os.fstat(descriptor).st_ino, "offset": offset, "head": _digest(head)}


def _digest(head: bytes) -> str:
    return sha256(head).hexdigest()[:16]
