"""What is said of a connection that comes and goes."""

from __future__ import annotations

from collections import deque

from hydrofdi.monitor.lines import Event, EventKind

_MOST_SAID = 3
"""Connections that break soon after each other, of which all is said."""


class Announcements:
    """Says when a connection comes, and once each reason why there is none.

    What breaks again and again is said a few times; then it is counted alone, until it holds.

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
        """All since the last call."""
        return tuple(self._events.popleft() for _ in range(len(self._events)))

    def doubt(self, text: str) -> None:
        """Something is less safe than it could be."""
        self._events.append(Event(EventKind.INSECURE, text))

    def connected(self, remark: str = "") -> None:
        """There is a connection."""
        self._reasons.clear()
        self._n_short += 1
        self._say(EventKind.CONNECTED, f"connected to {self._address}{remark}")

    def lost(self, reason: str) -> None:
        """There is no connection, or still none."""
        if reason not in self._reasons:
            self._reasons.add(reason)
            again = "; this continues; the end of it is reported" if self._n_short == _MOST_SAID else ""
            self._say(
                EventKind.DISCONNECTED, f"no connection to {self._address}: {reason}; trying again{again}"
            )

    def steady(self) -> None:
        """The connection is stable."""
        if self._n_short > _MOST_SAID:
            self._n_short = 0
            self._say(EventKind.CONNECTED, f"connected to {self._address}, and the connection is stable")
        self._n_short = 0

    def _say(self, kind: EventKind, text: str) -> None:
        self._events.append(Event(kind, text, is_silent=self._n_short > _MOST_SAID))
