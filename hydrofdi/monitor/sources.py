"""What sources of streams have in common: samples, connections that are made again, and their passwords."""

from __future__ import annotations

import os
import random
import socket
import ssl
import stat
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from errno import EADDRINUSE
from hashlib import sha256
from pathlib import Path
from threading import Condition, Thread
from threading import Event as Signal
from typing import Any, Generic, TypeVar

import numpy as np

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address
from hydrofdi.records.streams import Chunk, Event, EventKind

Position = Mapping[str, Any]
"""Where a source continues after a restart: small, and valid as JSON. Empty if it cannot go back."""


def printable(name: str) -> str:
    """The name of a file with bytes that are not UTF-8 as escapes, so that logs and states can hold it."""
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


class StreamSource:
    """A stream of samples. One thread calls its methods; sockets, event loops and other threads are its own.

    A source may repeat samples, after a restart or as a broker does: the watch drops samples that are not
    later than the last one. The defaults below are those of a source that stores nothing.

    Attributes
    ----------
    name : str
        For display, without credentials.
    events : deque of Event
        What happened since somebody took them: lost connections, dropped samples.
    is_over : bool
        Whether nothing follows what was read.
    may_repeat_all : bool
        Whether a restart without a position may repeat the whole stream, as a pipe does; a broker repeats at
        most the last few seconds.
    is_file : bool
        Whether it is there as a whole.
    address : Address or None
        Of a topic, whose messages come over a connection that machines share.
    """

    is_over = may_repeat_all = is_file = False
    address: Address | None = None

    def __init__(self, name: str, events: deque[Event] | None = None) -> None:
        self.name = printable(name)
        self.events: deque[Event] = deque() if events is None else events

    def open(self, position: Position) -> None:
        """Begin at the position that an earlier run stored; it is empty at the first start."""

    def read(self, timeout: float) -> Chunk | None:
        """New samples, at most about 65,536; None if after `timeout` seconds there are none, or events.

        Small pieces may be gathered for `connections.GATHER` seconds.
        """
        raise NotImplementedError

    @property
    def position(self) -> Position:
        """Where to continue after all that was read; empty if it cannot go back."""
        return {}

    def confirm(self) -> None:
        """A state that contains all that was read is stored: a broker may discard it."""

    def close(self) -> None:
        """End connections, threads and files."""


def joined(chunks: Sequence[Chunk]) -> Chunk:
    """All samples in one chunk, NaN for a channel that a chunk does not have."""
    if len(chunks) == 1:
        return chunks[0]
    firsts = np.cumsum([0, *(chunk.n_time for chunk in chunks)]).tolist()
    channels = {channel: np.full(firsts[-1], np.nan) for chunk in chunks for channel in chunk.channels}
    unread: dict[int, str] = {}
    for first, chunk in zip(firsts, chunks, strict=False):
        unread |= {first + row: text for row, text in chunk.unread.items()}
        for channel, samples in chunk.channels.items():
            channels[channel][first : first + chunk.n_time] = samples
    return Chunk(np.concatenate([np.empty(0), *(chunk.time for chunk in chunks)]), channels, unread)


def malformed(what: str, text: str, reason: str) -> Chunk:
    """A line or a payload that is not understood: a sample that could not be read."""
    return Chunk(np.array([np.nan]), {}, {0: f"malformed {what} {text[:60]!r}: {reason}"})


GATHER = 0.5
"""Longest time that samples wait for more, so that those of many small pieces are read together [s]."""

FIRST_WAIT, _LONGEST_WAIT = 1.0, 120.0
"""Wait before the second attempt to connect, and the longest between attempts [s]."""

_STEADY = 60.0
"""Duration of a stable connection [s]; after it, the first new attempt comes soon."""


class Connection:
    """Connects again and again in a thread of its own, and reports when a connection is made or lost."""

    def __init__(self, peer: str, say: Callable[[Event], None]) -> None:
        self._peer, self.say = peer, say
        self.is_closing = Signal()
        self.said: set[str] = set()
        self._thread = Thread(target=self._keep, name=peer, daemon=True)

    def connect_once(self) -> str:
        """Connect; afterwards, why the connection ended or could not be made."""
        raise NotImplementedError

    def begin(self, doubts: Iterator[str]) -> None:
        """Report what is insecure, and begin to connect."""
        for doubt in doubts:
            self.say(Event(EventKind.INSECURE, doubt))
        self._thread.start()

    def end(self, timeout: float | None = None) -> None:
        """End the connection and its thread."""
        self.is_closing.set()
        if self._thread.is_alive():
            self._thread.join(timeout)

    def report_connected(self, remark: str = "") -> None:
        """Report a connection."""
        self.said.clear()
        self.say(Event(EventKind.CONNECTED, f"connected to {self._peer}{remark}"))

    def _keep(self) -> None:
        n_failed = 0
        while not self.is_closing.is_set():
            began = time.monotonic()
            reason = self.connect_once()
            if reason not in self.said and not self.is_closing.is_set():
                self.said.add(reason)
                text = f"no connection to {self._peer}: {reason}; trying again"
                self.say(Event(EventKind.DISCONNECTED, text))
            n_failed = 0 if time.monotonic() - began > _STEADY else n_failed + 1
            longest = min(_LONGEST_WAIT, FIRST_WAIT * 2.0 ** min(n_failed, 16))
            self.is_closing.wait(longest * random.uniform(0.5, 1.0))


def claimed(name: str, refusal: str) -> socket.socket:
    """Hold a name on this machine until it is closed, at the latest when the process ends.

    An abstract socket leaves no file behind; systems other than Linux have none, and refuse nobody.
    """
    held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        held.bind(f"\0hydrofdi {sha256(name.encode()).hexdigest()}")
    except OSError as error:
        held.close()
        if error.errno == EADDRINUSE:
            raise ConfigError(refusal) from None
    return held


Item = TypeVar("Item")


class Inbox(Generic[Item]):
    """Items and events from the thread of a connection, for the thread of the monitor.

    While it is full, it holds the sender up.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self.events: deque[Event] = deque()
        self._items: deque[tuple[Item, int]] = deque()
        self._size, self._is_closed = 0, False
        self._failure: BaseException | None = None
        self._changed = Condition()

    def put(self, item: Item, size: int) -> None:
        """Add an item, once there is room."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closed or self._has_room(size))
            self._items.append((item, size))
            self._size += size
            self._changed.notify_all()

    def say(self, event: Event) -> None:
        """Add an event."""
        with self._changed:
            self.events.append(event)
            self._changed.notify_all()

    def fail(self, failure: BaseException) -> None:
        """Pass on an exception that is a bug in hydrofdi; the monitor raises it."""
        with self._changed:
            self._failure = failure
            self._changed.notify_all()

    def take(self, timeout: float, most: int, enough: int = 0) -> list[Item]:
        """Items up to a sum of sizes, but at least one; none after `timeout` seconds or with an event.

        Before that, items of less than `enough` wait for more, at most `GATHER` seconds.
        """
        with self._changed:
            if self._changed.wait_for(lambda: self._items or self.events or self._failure, timeout):
                self._changed.wait_for(lambda: self._size >= enough or self.events or self._failure, GATHER)
            if self._failure is not None:
                raise self._failure
            items: list[Item] = []
            while self._items and (not items or self._items[0][1] <= most):
                item, size = self._items.popleft()
                items.append(item)
                self._size -= size
                most -= size
            self._changed.notify_all()
            return items

    @property
    def size(self) -> int:
        """Sum of the sizes of the items."""
        return self._size

    def close(self) -> None:
        """Hold nobody up any more."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _has_room(self, size: int) -> bool:
        return not self._items or self._size + size <= self._capacity


_EXTRA = ("paho", "asyncua", "cryptography", "prometheus_client")


@contextmanager
def needing_extra() -> Iterator[None]:
    """Imports of the libraries of an extra."""
    try:
        yield
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        if library not in _EXTRA:
            raise
        raise ConfigError(f"{library} is not installed; pip install 'hydrofdi[monitor]'") from None


def credentials(section: str, username: str, password_file: Path | None) -> tuple[str, str]:
    """User and password of a section of the configuration, or else of the environment; empty without any."""
    variable = f"HYDROFDI_{section.upper()}"
    username = username or os.environ.get(f"{variable}_USERNAME", "")
    password = os.environ.get(f"{variable}_PASSWORD", "")
    if password_file is not None:
        with usable(f"{section}.password_file", password_file):
            password = password_file.read_text(encoding="utf-8").rstrip("\r\n")
        if not password or "\n" in password:
            raise ConfigError(
                f"{section}.password_file: {password_file}: must contain one line, the password"
            )
    if password and not username:
        raise ConfigError(f"{section}.username: is missing; there is a password without a user")
    return username, password


@contextmanager
def usable(key: str, file: Path | None) -> Iterator[None]:
    """Raise errors of a file under its key, never with the content of the file."""
    try:
        yield
    except Exception as error:  # whatever a library raises on foreign content
        reason = error.strerror if isinstance(error, OSError) and not isinstance(error, ssl.SSLError) else ""
        raise ConfigError(f"{key}: {file}: {reason or 'is not what this key needs'}") from None


def exposed(*files: Path | None) -> Iterator[str]:
    """A sentence for each file that every user of the machine can read."""
    for file in files:
        if file is not None and file.exists() and file.stat().st_mode & stat.S_IROTH:
            yield f"{file}: every user of this machine can read it; use 'chmod 600'"


def network_reason(error: OSError) -> str:
    """What an error of the network means. It never contains what the other side sent."""
    match error:
        case ssl.SSLCertVerificationError():
            return f"its certificate is refused: {error.verify_message}"
        case ssl.SSLError():
            return f"no encrypted connection ({(error.reason or 'unknown').lower().replace('_', ' ')})"
        case socket.gaierror():
            return "its name cannot be resolved"
    return os.strerror(error.errno).lower() if error.errno else str(error) or "it does not answer"
