"""Standard input, and growing files that are found again after they are renamed, as streams."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Collection, Mapping
from glob import escape
from hashlib import sha256
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.text_lines import TextLines
from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import Chunk

BLOCK = 1 << 17
"""Bytes that are read at once: a few thousand samples."""

_LEAP = 2
"""Sample numbers that a restart skips, so that the gap is detected."""


class StandardInput(StreamSource):
    """Standard input, or another descriptor: a pipe, a file or a terminal. It cannot go back.

    Parameters
    ----------
    config : MonitorConfig, optional
        Its channels, its text and its limits.
    descriptor : int
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    """

    def __init__(
        self,
        config: MonitorConfig | None = None,
        descriptor: int = 0,
        needed: Collection[Channel] = (),
    ) -> None:
        self._config, self._descriptor, self._needed = config or MonitorConfig(), descriptor, needed
        self._is_over = False
        self._text = self._lines({})

    @property
    def name(self) -> str:
        """Standard input."""
        return "standard input"

    def open(self, position: Position) -> None:
        """Begin; the count of samples without time continues after a gap.

        Raises
        ------
        DataError
            Standard input is closed.
        """
        try:
            os.fstat(self._descriptor)
        except OSError:
            raise DataError("standard input is closed") from None
        counted = position.get("n_sample")
        self._text = self._lines({} if counted is None else {"n_sample": int(counted) + _LEAP})

    def read(self, timeout: float) -> Reading:
        """New samples and events; an empty reading after `timeout` seconds without any.

        Raises
        ------
        DataError
            The first line is not a usable header.
        """
        if self._is_over:
            return Reading(is_over=True)
        if not select.select([self._descriptor], [], [], timeout)[0]:
            return Reading()
        try:
            data = os.read(self._descriptor, BLOCK)
        except OSError:
            data = b""
        self._is_over = not data
        return Reading(self._text.read(data, is_end=self._is_over), (), self._is_over)

    @property
    def position(self) -> Position:
        """The number of samples without time."""
        counted = self._text.position.get("n_sample")
        return {} if counted is None else {"n_sample": counted}

    @property
    def may_repeat_all(self) -> bool:
        """True: the writer may begin anew."""
        return True

    def close(self) -> None:
        """Do nothing."""

    def _lines(self, position: Position) -> TextLines:
        return TextLines(self._config, self.name, position, self._needed)


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


_POLL = 0.1
"""Time between checks of a file that does not grow [s]."""


class GrowingFile(StreamSource):
    """A text file, read from its beginning and followed as it grows.

    A renamed file is read to its end; then the new file with its name is read, once it is not empty. A file
    that was cut is read from its beginning, also if it has grown again. A file that does not exist yet is
    waited for.

    Parameters
    ----------
    path : path
    config : MonitorConfig, optional
        Its channels, its text and its limits.
    follow : bool
        Whether to wait for more at the end.
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    leaves_unended : bool
        Whether a last line without a line end is left for a later run; else it is read if nobody follows.
    """

    def __init__(
        self,
        path: Path,
        config: MonitorConfig | None = None,
        follow: bool = True,
        needed: Collection[Channel] = (),
        *,
        leaves_unended: bool = False,
    ) -> None:
        self._path, self._follow, self._needed = path, follow, needed
        self._leaves_unended = leaves_unended
        self._config = config or MonitorConfig()
        self._text = self._lines({})
        self._file: FollowedFile | None = None
        self._stored: Mapping[str, Any] = {}
        self._events: list[Event] = []
        self._trouble = ""
        self._is_over = False

    @property
    def name(self) -> str:
        """The path of the file."""
        return str(self._path)

    def open(self, position: Position) -> None:
        """Begin at the unfinished line of an earlier run, or at the beginning.

        Raises
        ------
        DataError
            It is a folder, compressed or not readable, or it does not exist and is not followed.
        """
        if self._path.suffix.lower() == ".gz":
            raise DataError(
                f"{self._path}: is compressed and cannot be read as a stream; decompress it first"
            )
        if self._path.exists() and not self._path.is_file():
            raise DataError(f"{self._path}: is not a regular file; read it from standard input, '-'")
        self._stored = dict(position)
        try:
            self._go_on()
        except FileNotFoundError as error:
            if not self._follow:
                raise DataError(f"{self._path}: no such file") from None
            self._trouble_with(error)
        except OSError as error:
            raise DataError(f"{self._path}: cannot be read: {error.strerror}") from None

    def read(self, timeout: float) -> Reading:
        """New samples and events; an empty reading after `timeout` seconds without any.

        Raises
        ------
        DataError
            The first line is not a usable header.
        """
        end = time.monotonic() + timeout
        while True:
            chunk = self._next()
            events, self._events = tuple(self._events), []
            left = end - time.monotonic()
            if chunk is not None or events or self._is_over or left <= 0.0:
                return Reading(chunk, events, self._is_over)
            time.sleep(min(_POLL, left))

    @property
    def position(self) -> Position:
        """The file, the position of its unfinished line, and its header."""
        if self._file is None:
            return self._stored
        return self._file.position(self._text.n_unfinished) | self._text.position

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._stored = self.position
            self._file.close()
            self._file = None

    def _next(self) -> Chunk | None:
        try:
            if self._file is None:
                self._go_on()
            return None if self._file is None else self._read(self._file)
        except OSError as error:
            self._trouble_with(error)
            return None

    def _go_on(self) -> None:
        """Open the file at the stored position, or at its beginning."""
        stored = self._stored
        found = found_again(self._path, stored) if "inode" in stored else None
        file = found or FollowedFile(self._path)
        if self._trouble:
            self._say("can be read now")
        if "inode" in stored and found is None:
            self._say("the previous file is gone; this one is read from the start")
            stored = {key: value for key, value in stored.items() if key == "n_sample"}
        self._file, self._text, self._trouble = file, self._lines(stored), ""

    def _read(self, file: FollowedFile) -> Chunk | None:
        data = file.read(BLOCK)
        if file.was_begun_anew() or (not data and file.was_truncated()):
            self._say("was cut; it is read from the start")
            self._text.forget_unfinished()
            file.begin_anew()
        elif data:
            return self._text.read(data)
        elif self._is_replaced(file):
            if data := file.read(BLOCK):
                return self._text.read(data)
            self._file = FollowedFile(following(self._path, file))
            self._say("is a new file; the old one was read to its end")
            file.close()
            return self._text.read(b"", is_end=True)
        elif not self._follow:
            self._is_over = True
            return None if self._leaves_unended else self._text.read(b"", is_end=True)
        return None

    def _is_replaced(self, file: FollowedFile) -> bool:
        """Whether another file has the name now, and is not empty."""
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return False
        return found.st_ino != file.inode and found.st_size > 0

    def _trouble_with(self, error: OSError) -> None:
        """Report once what is wrong; the next reading tries again."""
        self.close()
        is_missing = isinstance(error, FileNotFoundError)
        text = "does not exist yet; waiting for it" if is_missing else f"cannot be read: {error.strerror}"
        if text != self._trouble:
            self._trouble = text
            self._say(text, EventKind.NOTICE if is_missing else EventKind.DISCONNECTED)

    def _say(self, text: str, kind: EventKind = EventKind.CONNECTED) -> None:
        self._events.append(Event(kind, f"{self._path}: {text}"))

    def _lines(self, position: Position) -> TextLines:
        return TextLines(self._config, self.name, position, self._needed)
