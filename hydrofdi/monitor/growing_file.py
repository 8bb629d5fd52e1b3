"""Standard input, and growing files that are found again after they are renamed, as streams."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Collection, Mapping
from functools import partial
from glob import escape
from hashlib import sha256
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources import GATHER, Position, StreamSource, joined
from hydrofdi.monitor.text_lines import TextLines
from hydrofdi.records import Channel
from hydrofdi.records.rows import UNENDED
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.store.files import reason

BLOCK = 1 << 17
"""Bytes that are read at once: a few thousand samples."""

_LEAP = 2
"""Sample numbers that a restart skips, so that the gap is detected."""


class StandardInput(StreamSource):
    """Standard input, or another descriptor: a pipe, a file or a terminal. It cannot go back."""

    may_repeat_all = True

    def __init__(
        self, config: MonitorConfig | None = None, descriptor: int = 0, needed: Collection[Channel] = ()
    ) -> None:
        super().__init__("standard input")
        self._descriptor = descriptor
        self._lines = partial(TextLines, config or MonitorConfig(), self.name, needed=needed)
        self._text = self._lines({})

    def open(self, position: Position) -> None:
        """Begin; the count of samples without time continues after a gap."""
        try:
            os.fstat(self._descriptor)
        except OSError:
            raise DataError("standard input is closed") from None
        self._text = self._lines({key: int(count) + _LEAP for key, count in position.items()})

    def read(self, timeout: float) -> Chunk | None:
        """New samples; None after `timeout` seconds without any."""
        data, end = b"", time.monotonic() + timeout
        while not self.is_over and len(data) < BLOCK and self._has_more(end - time.monotonic()):
            end = end if data else time.monotonic() + GATHER
            piece = self._piece()
            data, self.is_over = data + piece, not piece
        chunks = [self._text.read(data)]
        if self.is_over:
            if self._text.n_unfinished:
                self.events.append(Event(EventKind.NOTICE, f"{self.name}: {UNENDED}"))
            chunks.append(self._text.read(b"", is_end=True))
        readable = [chunk for chunk in chunks if chunk is not None]
        return joined(readable) if readable else None

    def _has_more(self, timeout: float) -> bool:
        return bool(select.select([self._descriptor], [], [], max(0.0, timeout))[0])

    def _piece(self) -> bytes:
        """The next bytes; empty at the end."""
        try:
            return os.read(self._descriptor, BLOCK)
        except OSError:
            return b""

    @property
    def position(self) -> Position:
        """The number of samples without time."""
        return {key: count for key, count in self._text.position.items() if key == "n_sample"}


_HEAD = 4096
"""Bytes at the beginning that distinguish a file from a later one with the same inode."""


class FollowedFile:
    """An open file, and the position of the next byte."""

    def __init__(self, path: Path, offset: int = 0) -> None:
        self._file = open(path, "rb", buffering=0)  # noqa: SIM115
        self._head = self._file.read(min(_HEAD, offset))
        self._file.seek(offset)
        self.offset = offset

    @property
    def status(self) -> os.stat_result:
        """Its present size, and the time of the last write."""
        return os.fstat(self._file.fileno())

    def read(self, n_byte: int) -> bytes:
        """The next bytes; empty at the end."""
        data = self._file.read(n_byte)
        self.offset += len(data)
        if len(self._head) < _HEAD:
            self._head = (self._head + data)[:_HEAD]
        return data

    def position(self, offset: int) -> dict[str, Any]:
        """The position of a byte that was read."""
        return place_in(self._file.fileno(), offset, self._head)

    def was_begun_anew(self) -> bool:
        """Whether it begins otherwise than what was read; a hole is what a writer leaves that went on."""
        head = os.pread(self._file.fileno(), len(self._head), 0)
        return not head.startswith(b"\0") and not self._head.startswith(head)

    def begin_anew(self) -> None:
        """Read from the beginning."""
        self._file.seek(0)
        self.offset, self._head = 0, b""

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def found_again(path: Path, position: Position) -> FollowedFile | None:
    """The file of a stored position, under its name or another one beside it; None if it is gone."""
    for candidate in (path, *sorted(path.parent.iterdir())):
        if not candidate.is_file() or candidate.stat().st_ino != position["inode"]:
            continue
        offset = int(position["offset"])
        file = FollowedFile(candidate, offset)
        if file.status.st_size >= offset and file.position(offset)["head"] == position["head"]:
            return file
        file.close()
    return None


def following(path: Path, file: FollowedFile) -> Path:
    """The file that was begun after `file` was renamed: a file that was renamed later, or the one at `path`.

    Renamed files are those in the folder of `path` whose names begin with its name, as with logrotate.
    """
    later = [
        (renamed.stat().st_mtime_ns, renamed)
        for renamed in path.parent.glob(f"{escape(path.name)}?*")
        if renamed.suffix.lower() != ".gz"
        and renamed.is_file()
        and renamed.stat().st_ino != file.status.st_ino
    ]
    return min([pair for pair in later if pair[0] > file.status.st_mtime_ns], default=(0, path))[1]


def place_in(descriptor: int, offset: int, head: bytes | None = None) -> dict[str, Any]:
    """The position of a byte in an open file, of which the beginning may be known."""
    head = os.pread(descriptor, min(_HEAD, offset), 0) if head is None else head[:offset]
    return {"inode": os.fstat(descriptor).st_ino, "offset": offset, "head": sha256(head).hexdigest()[:16]}


_POLL = 0.2
"""Time between checks of a file that does not grow [s]."""


class GrowingFile(StreamSource):
    """A text file, read from its beginning and followed as it grows.

    A renamed file is read to its end; then the new file with its name is read, once it is not empty. A file
    that was cut is read from its beginning, also if it has grown again. A file that does not exist yet is
    waited for.
    """

    is_file = True

    def __init__(
        self,
        path: Path,
        config: MonitorConfig | None = None,
        follow: bool = True,
        needed: Collection[Channel] = (),
        *,
        leaves_unended: bool = False,
    ) -> None:
        super().__init__(str(path))
        self._path, self._follow, self._leaves_unended = path, follow, leaves_unended
        self._lines = partial(TextLines, config or MonitorConfig(), self.name, needed=needed)
        self._text = self._lines({})
        self._file: FollowedFile | None = None
        self._stored: Mapping[str, Any] = {}
        self._trouble = ""

    def open(self, position: Position) -> None:
        """Begin at the unfinished line of an earlier run, or at the beginning."""
        if self._path.suffix.lower() == ".gz":
            raise DataError(f"{self._path}: is compressed; decompress it first")
        if self._path.exists() and not self._path.is_file():
            raise DataError(f"{self._path}: is not a regular file; read it from standard input, '-'")
        self._stored = dict(position)
        try:
            self._go_on()
        except OSError as error:
            if not (self._follow and isinstance(error, FileNotFoundError)):
                raise DataError(f"{self._path}: cannot be read: {reason(error)}") from None
            self._report(error)

    def read(self, timeout: float) -> Chunk | None:
        """New samples; None after `timeout` seconds without any, or if something happened."""
        end = time.monotonic() + timeout
        while True:
            before = self._file.offset if self._file else -1
            chunk = self._next()
            left = end - time.monotonic()
            if chunk is not None or self.events or self.is_over or left <= 0.0:
                return chunk
            if self._file is None or self._file.offset == before:  # part of a long line is no reason to wait
                time.sleep(min(_POLL, left))

    @property
    def position(self) -> Position:
        """The file, the position of its unfinished line, and its header."""
        if self._file is None:
            return self._stored
        return self._file.position(self._file.offset - self._text.n_unfinished) | self._text.position

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._stored = self.position
            self._file.close()
            self._file = None

    def _next(self) -> Chunk | None:
        try:
            return self._read(self._file or self._go_on())
        except OSError as error:
            self._report(error)
            return None

    def _go_on(self) -> FollowedFile:
        """Open the file at the stored position, or at its beginning."""
        stored = self._stored
        old = found_again(self._path, stored) if "inode" in stored else None
        self._file = old or FollowedFile(self._path)
        if self._trouble:
            self._say("can be read now")
        if "inode" in stored and old is None:
            self._say("the previous file is gone; this one is read from the start")
            stored = {key: value for key, value in stored.items() if key == "n_sample"}
        self._text, self._trouble = self._lines(stored), ""
        return self._file

    def _read(self, file: FollowedFile) -> Chunk | None:
        data = file.read(BLOCK)
        if file.was_begun_anew() or (not data and file.status.st_size < file.offset):
            self._say("was cut; it is read from the start")
            self._text.begin_anew()
            file.begin_anew()
        elif data:
            return self._text.read(data)
        elif self._is_replaced(file):
            if data := file.read(BLOCK):
                return self._text.read(data)
            self._file = FollowedFile(following(self._path, file))
            self._say("is a new file; the old one was read to its end")
            file.close()
            chunk = self._last()
            self._text.begin_anew()
            return chunk
        elif not self._follow:
            self.is_over = True
            return None if self._leaves_unended else self._last()
        return None

    def _last(self) -> Chunk | None:
        """The sample of a last line without line end."""
        if self._text.n_unfinished:
            self._say(UNENDED, EventKind.NOTICE)
        return self._text.read(b"", is_end=True)

    def _is_replaced(self, file: FollowedFile) -> bool:
        """Whether another file has the name now, and is not empty."""
        try:
            status = self._path.stat()
        except FileNotFoundError:
            return False
        return status.st_size > 0 and not os.path.samestat(status, file.status)

    def _report(self, error: OSError) -> None:
        """Report once what is wrong; the next reading tries again."""
        self.close()
        is_missing = isinstance(error, FileNotFoundError)
        text = "does not exist yet; waiting for it" if is_missing else f"cannot be read: {reason(error)}"
        if text != self._trouble:
            self._trouble = text
            self._say(text, EventKind.NOTICE if is_missing else EventKind.DISCONNECTED)

    def _say(self, text: str, kind: EventKind = EventKind.CONNECTED) -> None:
        self.events.append(Event(kind, f"{self._path}: {text}"))
