"""A growing file as a stream."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources.columns import Channels
from hydrofdi.monitor.sources.contract import Position, Reading, StreamSource
from hydrofdi.monitor.sources.payload import LARGEST
from hydrofdi.monitor.sources.text.config import TextConfig
from hydrofdi.monitor.sources.text.followed_file import FollowedFile, following, found_again
from hydrofdi.monitor.sources.text.lines import TextLines
from hydrofdi.monitor.sources.text.standard_input import BLOCK
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk

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
    channels : mapping of Channel to ChannelConfig, optional
    config : TextConfig, optional
    follow : bool
        Whether to wait for more at the end.
    largest : int
                Longest line [bytes].
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    """

    def __init__(
        self,
        path: Path,
        channels: Channels | None = None,
        config: TextConfig | None = None,
        follow: bool = True,
        largest: int = LARGEST,
        needed: Collection[Channel] = (),
    ) -> None:
        self._needed = needed
        self._path, self._follow, self._largest = path, follow, largest
        self._channels, self._config = channels or {}, config or TextConfig()
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
            return self._parsed(data)
        elif self._is_replaced(file):
            if data := file.read(BLOCK):
                return self._parsed(data)
            self._file = FollowedFile(following(self._path, file))
            self._say("is a new file; the old one was read to its end")
            file.close()
            return self._parsed(b"", is_end=True)
        elif not self._follow:
            self._is_over = True
            return self._parsed(b"", is_end=True)
        return None

    def _is_replaced(self, file: FollowedFile) -> bool:
        """Whether another file has the name now, and is not empty."""
        try:
            found = self._path.stat()
        except FileNotFoundError:
            return False
        return found.st_ino != file.inode and found.st_size > 0

    def _parsed(self, data: bytes, *, is_end: bool = False) -> Chunk | None:
        return self._text.read(data, is_end=is_end)

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
        return TextLines(self._channels, self._config, self.name, position, self._largest, self._needed)
