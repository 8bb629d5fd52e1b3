"""Events of a connection that is made and lost."""

from __future__ import annotations

from collections import deque

from hydrofdi.monitor.lines import Event, EventKind

_MOST_SAID = 3
"""Number of short connections in a row that are all reported."""


class Announcements:
    """Reports when a connection is made, and once each reason why there is none.

    A connection that breaks repeatedly is reported a few times, then only counted until it is stable.

    Parameters
    ----------
    address : str
    """

    def __init__(self, address: str) -> None:
        self._address = address
        self._events: deque[Event] = deque(maxlen=1000)
        self._reasons: set[str] = set()
        self._n_short = 0

    def take(self) -> tuple[Event, ...]:
        """All events since the last call."""
        return tuple(self._events.popleft() for _ in range(len(self._events)))

    def doubt(self, text: str) -> None:
        """Report that something is less safe than it could be."""
        self._events.append(Event(EventKind.INSECURE, text))

    def connected(self, remark: str = "") -> None:
        """Report a connection."""
        self._reasons.clear()
        self._n_short += 1
        self._say(EventKind.CONNECTED, f"connected to {self._address}{remark}")

    def lost(self, reason: str) -> None:
        """Report that there is no connection, or still none."""
        if reason not in self._reasons:
            self._reasons.add(reason)
            again = "; next report when the connection is stable" if self._n_short == _MOST_SAID else ""
            self._say(
                EventKind.DISCONNECTED, f"no connection to {self._address}: {reason}; trying again{again}"
            )

    def steady(self) -> None:
        """Report that the connection is stable."""
        if self._n_short > _MOST_SAID:
            self._n_short = 0
            self._say(EventKind.CONNECTED, f"connected to {self._address}, and the connection is stable")
        self._n_short = 0

    def _say(self, kind: EventKind, text: str) -> None:
        self._events.append(Event(kind, text, is_silent=self._n_short > _MOST_SAID))
