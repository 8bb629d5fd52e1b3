"""What a live view knows of a stream: arrivals, last samples, last windows, and counts."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Sequence

import numpy as np

from hydrofdi.api.monitoring.lines import Condition, Event, EventKind, Line, WindowLine
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk

_MOST_WINDOWS, _MOST_EVENTS, _MOST_SAMPLES = 100, 50, 50_000
_SECONDS_WITHOUT_WINDOWS = 10.0
"""Duration whose samples are summed up if estimates are judged."""
_SECONDS_OF_RATE = 5.0
"""Duration over which the rate of samples is averaged."""
_SILENT_AFTER = 5.0
"""Least time without samples after which the last condition is out of date [s]."""


class Arrivals:
    """Arrival times of samples."""

    def __init__(self) -> None:
        self._opened = time.monotonic()
        self._last: float | None = None
        self._least_delay = float("inf")
        self._counts: deque[tuple[float, int]] = deque()
        self.lag = 0.0
        """Delay of the last sample, relative to the sample with the smallest delay [s]."""

    def add(self, n_time: int, instant: float) -> None:
        """Note that `n_time` samples arrived, the last with the time stamp `instant` [s]."""
        self._last = now = time.monotonic()
        self._least_delay = min(self._least_delay, now - instant)
        self.lag = now - instant - self._least_delay
        self._counts.append((now, n_time))

    @property
    def age(self) -> float:
        """Time since the start [s]."""
        return time.monotonic() - self._opened

    @property
    def rate(self) -> float:
        """Samples per second, over the last seconds [Hz]."""
        while self._counts and time.monotonic() - self._counts[0][0] > _SECONDS_OF_RATE:
            self._counts.popleft()
        return sum(n_time for _, n_time in self._counts) / min(_SECONDS_OF_RATE, max(self.age, 0.2))

    @property
    def silence(self) -> float:
        """Time since the last arrival [s]."""
        return self.age if self._last is None else time.monotonic() - self._last


class Watched:
    """Samples, windows and events since the view was opened. Memory is bounded.

    Attributes
    ----------
    arrivals : Arrivals
    condition : Condition
    since : float or None
        End of the window with which the condition began [s].
    time : float or None
        Instant of the last sample [s].
    windows : deque of WindowLine
    events : deque of Event
    counts, faults : Counter
        Kind of event → number of events; kind of fault → number of windows that are not judged because of it.
    n_beyond : int
                Number of judged windows beyond the limit.
    alarms : deque of float
        When the last alarms were raised [s].
    n_unread, unread_text : int, str
        Number of malformed lines or messages since the last sample, and the text about the first.
    n_tail : int
        Number of last samples of a channel that are kept.
    is_connected : bool or None
        None for sources that have no connection.
    """

    def __init__(self, file: DetectorFile, source: str) -> None:
        self.file, self.source = file, source
        self.arrivals = Arrivals()
        self.condition = Condition.UNKNOWN
        self.since: float | None = None
        self.time: float | None = None
        self.windows: deque[WindowLine] = deque(maxlen=_MOST_WINDOWS)
        self.events: deque[Event] = deque(maxlen=_MOST_EVENTS)
        self.counts: Counter[EventKind] = Counter()
        self.faults: Counter[str] = Counter()
        self.n_window = self.n_beyond = self.n_unread = 0
        self.unread_text = ""
        self.alarms: deque[float] = deque(maxlen=_MOST_EVENTS)
        self.is_connected: bool | None = None
        n_wanted = file.n_sample or round(_SECONDS_WITHOUT_WINDOWS * file.sampling_frequency)
        self.n_tail = max(min(n_wanted, _MOST_SAMPLES), 1)
        self._tails: dict[Channel, deque[float]] = {
            each: deque(maxlen=self.n_tail) for each in Channel if each in file.channels
        }

    def take(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Take samples and their lines."""
        if chunk is not None and chunk.readable.n_time:
            self._take_samples(chunk.readable)
        if chunk is not None and chunk.unread:
            self.unread_text = self.unread_text if self.n_unread else next(iter(chunk.unread.values()))
            self.n_unread += len(chunk.unread)
        for line in lines:
            if isinstance(line, WindowLine):
                self._take_window(line)
            else:
                self._take_event(line)

    def _take_samples(self, chunk: Chunk) -> None:
        self.time, self.n_unread = float(chunk.time[-1]), 0
        self.arrivals.add(chunk.n_time, self.time)
        if self.is_connected is not None:
            self.is_connected = True
        for channel, tail in self._tails.items():
            if channel in chunk.channels:
                tail.extend(chunk.channels[channel][-self.n_tail :].tolist())

    def _take_window(self, line: WindowLine) -> None:
        if line.condition is not self.condition:
            self.condition, self.since = line.condition, line.end
        self.n_window += 1
        self.n_beyond += bool(line.verdict.alarm)
        if line.verdict.fault is not None:
            self.faults[line.verdict.fault.kind] += 1
        self.windows.append(line)

    def _take_event(self, event: Event) -> None:
        is_nothing_lost = event.kind is EventKind.DISCONNECTED and not self._was_connected
        self.counts[event.kind] += 0 if is_nothing_lost or event.is_end else event.count
        if event.kind in (EventKind.CONNECTED, EventKind.DISCONNECTED):
            self.is_connected = event.kind is EventKind.CONNECTED
        if event.kind is EventKind.ALARM_RAISED and event.time is not None:
            self.alarms.append(event.time)
        if not event.is_silent:
            self.events.append(event)

    @property
    def _was_connected(self) -> bool:
        return self.time is not None if self.is_connected is None else self.is_connected

    @property
    def tails(self) -> dict[Channel, Array]:
        """Last samples of the channels that have some: those of a window, unless it is very long."""
        return {channel: np.array(tail) for channel, tail in self._tails.items() if tail}

    @property
    def n_judged(self) -> int:
        """Number of judged windows."""
        return self.n_window - self.faults.total()

    @property
    def is_silent(self) -> bool:
        """Whether the present condition is unknown: no connection, or no samples for two windows."""
        patience = max(_SILENT_AFTER, 2.0 * self.file.n_sample / self.file.sampling_frequency)
        return self.is_connected is False or self.time is None or self.arrivals.silence > patience
