"""A bounded queue of samples from a live source to the monitor."""

from __future__ import annotations

from collections import deque
from threading import Condition

import numpy as np

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources.contract import Reading
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk

_MOST = 65_536


class SampleQueue:
    """Samples and events from the thread of a connection, for the thread of the monitor.

    When it is full, new samples are dropped until the monitor reads: one long gap, not many short ones.

    Parameters
    ----------
    channels : tuple of Channel
    capacity : int
                Most samples in the queue.
    """

    def __init__(self, channels: tuple[Channel, ...], capacity: int) -> None:
        self._channels, self._capacity = channels, capacity
        self._pieces: deque[tuple[Array, Array]] = deque()
        self._events: list[Event] = []
        self._n_held = self._n_dropped = 0
        self._is_dropping = False
        self._failure: BaseException | None = None
        self._changed = Condition()

    def put(self, time: Array, samples: Array) -> None:
        """Add samples in SI: instants (n_time,) [s] and values (n_time, n_channel)."""
        if not time.size:
            return
        with self._changed:
            if self._is_dropping or (self._n_held and self._n_held + time.size > self._capacity):
                self._drop(time)
            else:
                self._pieces.append((time, samples))
                self._n_held += time.size
            self._changed.notify()

    def say(self, event: Event) -> None:
        """Add an event."""
        with self._changed:
            self._events.append(event)
            self._changed.notify()

    def fail(self, failure: BaseException) -> None:
        """Pass on an exception that is a bug in hydrofdi; the monitor raises it."""
        with self._changed:
            self._failure = failure
            self._changed.notify()

    def take(self, timeout: float) -> Reading:
        """The waiting samples and events; an empty reading after `timeout` seconds without any."""
        with self._changed:
            self._changed.wait_for(self._has_news, timeout)
            if self._failure is not None:
                raise self._failure
            events, self._events = tuple(self._events), []
            if self._n_dropped:
                events += (self._dropped(self._n_dropped, None, is_silent=True),)
                self._n_dropped = 0
            return Reading(self._chunk(), events)

    def _has_news(self) -> bool:
        return bool(self._pieces or self._events or self._n_dropped or self._failure)

    def _drop(self, time: Array) -> None:
        if self._is_dropping:
            self._n_dropped += time.size
        else:
            self._events.append(self._dropped(time.size, float(time[0]), is_silent=False))
        self._is_dropping = True

    def _dropped(self, count: int, time: float | None, *, is_silent: bool) -> Event:
        text = "the monitor is slower than the stream: samples that come while its queue is full are dropped"
        return Event(EventKind.DROPPED, text, time, count, is_silent)

    def _chunk(self) -> Chunk | None:
        self._is_dropping = False
        taken: list[tuple[Array, Array]] = []
        n_taken = 0
        while self._pieces and (not taken or n_taken + self._pieces[0][0].size <= _MOST):
            taken.append(self._pieces.popleft())
            n_taken += taken[-1][0].size
        self._n_held -= n_taken
        if not taken:
            return None
        samples = np.concatenate([samples for _, samples in taken])
        columns = {channel: samples[:, position] for position, channel in enumerate(self._channels)}
        return Chunk(np.concatenate([time for time, _ in taken]), columns)
