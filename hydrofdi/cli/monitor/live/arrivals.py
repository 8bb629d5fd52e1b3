"""Rate and delay of arriving samples."""

from __future__ import annotations

import time
from collections import deque

_SECONDS_OF_RATE = 5.0
"""Duration over which the rate is averaged."""


class Arrivals:
    """Arrival times of samples."""

    def __init__(self) -> None:
        self._opened = time.monotonic()
        self._last: float | None = None
        self._lag = 0.0
        self._least_delay = float("inf")
        self._counts: deque[tuple[float, int]] = deque()

    def add(self, n_time: int, instant: float) -> None:
        """Note that `n_time` samples arrived, the last with the time stamp `instant` [s]."""
        self._last = now = time.monotonic()
        self._least_delay = min(self._least_delay, now - instant)
        self._lag = now - instant - self._least_delay
        self._counts.append((now, n_time))
        self._forget(now)

    def _forget(self, now: float) -> None:
        while self._counts and now - self._counts[0][0] > _SECONDS_OF_RATE:
            self._counts.popleft()

    @property
    def age(self) -> float:
        """Time since the start [s]."""
        return time.monotonic() - self._opened

    @property
    def rate(self) -> float:
        """Samples per second, over the last seconds [Hz]."""
        self._forget(time.monotonic())
        return sum(n_time for _, n_time in self._counts) / min(_SECONDS_OF_RATE, max(self.age, 0.2))

    @property
    def lag(self) -> float:
        """Delay of the last sample, relative to the sample with the smallest delay [s]."""
        return self._lag

    @property
    def silence(self) -> float:
        """Time since the last arrival [s]."""
        return self.age if self._last is None else time.monotonic() - self._last
