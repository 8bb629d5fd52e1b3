"""A bounded queue from the thread of a connection to the monitor."""

from __future__ import annotations

from collections import deque
from threading import Condition
from typing import Generic, TypeVar

from hydrofdi.monitor.lines import Event, EventKind

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
