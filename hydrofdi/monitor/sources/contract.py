"""The contract of sources, and what they have in common."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Condition
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.records.streams import Chunk

Position = Mapping[str, Any]
"""Where a source continues after a restart: small, and valid as JSON. Empty if it cannot go back."""


@dataclass(frozen=True)
class Reading:
    """What was read from a source.

    Attributes
    ----------
    chunk : Chunk or None
        New samples; at most about 65,536, so that results come steadily.
    events : tuple of Event
        Events in the meantime: malformed payloads, lost connections, dropped samples.
    is_over : bool
        Whether nothing will follow.
    """

    chunk: Chunk | None = None
    events: tuple[Event, ...] = ()
    is_over: bool = False


class StreamSource(Protocol):
    """A stream of samples. One thread calls its methods; sockets, event loops and other threads are its own.

    A source may repeat samples, after a restart or as a broker does: the watch drops samples that are not
    later than the last one. The defaults below are those of a source that stores nothing.
    """

    @property
    def name(self) -> str:
        """Name for display, without credentials."""
        ...

    def open(self, position: Position) -> None:
        """Begin at the position that an earlier run stored; it is empty at the first start.

        Raises
        ------
        DataError
            It cannot be used: no such file, no permission. A server that does not answer is not an error.
        """
        ...

    def read(self, timeout: float) -> Reading:
        """New samples and events; an empty reading after `timeout` seconds without any."""
        ...

    @property
    def position(self) -> Position:
        """Where to continue after all that was read; empty if it cannot go back."""
        return {}

    @property
    def may_repeat_all(self) -> bool:
        """Whether a restart without a position may repeat the whole stream, as a pipe does; a broker repeats
        at most the last few seconds."""
        return False

    @property
    def wants_confirmation(self) -> bool:
        """Whether so much was read since the last confirmation that the state should be stored now."""
        return False

    def confirm(self) -> None:
        """A state that contains all that was read is stored: a broker may discard it."""
        return

    def close(self) -> None:
        """End connections, threads and files."""
        ...


def joined(chunks: Sequence[Chunk]) -> Chunk:
    """All samples in one chunk; NaN for a channel that a chunk does not have."""
    if len(chunks) == 1:
        return chunks[0]
    channels = dict.fromkeys(channel for chunk in chunks for channel in chunk.channels)
    return Chunk(
        np.concatenate([np.empty(0), *(chunk.time for chunk in chunks)]),
        {
            channel: np.concatenate(
                [
                    np.full(chunk.n_time, np.nan) if (own := chunk.channels.get(channel)) is None else own
                    for chunk in chunks
                ]
            )
            for channel in channels
        },
        {
            int(first) + place: text
            for first, chunk in zip(np.cumsum([0, *(chunk.n_time for chunk in chunks)]), chunks, strict=False)
            for place, text in chunk.unread.items()
        },
    )


def malformed(what: str, text: str, reason: str) -> Chunk:
    """A line or a payload that is not understood: a sample that could not be read."""
    return Chunk(np.array([np.nan]), {}, {0: f"malformed {what} {text[:60]!r}: {reason}"})


Item = TypeVar("Item")

_DROPPED = "the monitor is slower than the stream: what comes while its queue is full is lost"


class Inbox(Generic[Item]):
    """Items and events from the thread of a connection, for the thread of the monitor.

    While it is full, it holds the sender up, or drops all until it is empty: one long gap, not many short
    ones.

    Parameters
    ----------
    capacity : int
        Largest sum of the sizes of its items.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._items: deque[tuple[Item, int]] = deque()
        self._events: list[Event] = []
        self._size = self._n_dropped = 0
        self._is_dropping = self._is_closed = False
        self._failure: BaseException | None = None
        self._changed = Condition()

    def put(
        self, item: Item, size: int, *, waits: bool = False, count: int = 1, time: float | None = None
    ) -> None:
        """Add an item. Without room, wait; or drop it, which counts `count` from `time` [s] on."""
        with self._changed:
            if waits:
                self._changed.wait_for(lambda: self._is_closed or self._has_room(size))
            elif self._is_dropping:
                self._n_dropped += count
                return
            elif not self._has_room(size):
                self._is_dropping = True
                self._events.append(Event(EventKind.DROPPED, _DROPPED, time, count))
                return
            self._items.append((item, size))
            self._size += size
            self._changed.notify_all()

    def say(self, event: Event) -> None:
        """Add an event."""
        with self._changed:
            self._events.append(event)
            self._changed.notify_all()

    def fail(self, failure: BaseException) -> None:
        """Pass on an exception that is a bug in hydrofdi; the monitor raises it."""
        with self._changed:
            self._failure = failure
            self._changed.notify_all()

    def take(self, timeout: float, most: int) -> tuple[list[Item], list[Event]]:
        """Items up to a sum of sizes, but at least one, and events; none after `timeout` seconds."""
        with self._changed:
            self._changed.wait_for(lambda: self._items or self._events or self._failure, timeout)
            if self._failure is not None:
                raise self._failure
            events, self._events = self._events, []
            if self._n_dropped:
                events.append(Event(EventKind.DROPPED, _DROPPED, None, self._n_dropped, is_silent=True))
            items: list[Item] = []
            while self._items and (not items or self._items[0][1] <= most):
                item, size = self._items.popleft()
                items.append(item)
                self._size -= size
                most -= size
            self._n_dropped, self._is_dropping = 0, self._is_dropping and bool(self._items)
            self._changed.notify_all()
            return items, events

    def close(self) -> None:
        """Hold nobody up any more."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def _has_room(self, size: int) -> bool:
        return not self._items or self._size + size <= self._capacity
