"""Lines or payloads that are not understood: counted, and reported once."""

from __future__ import annotations

from hydrofdi.monitor.lines import Event, EventKind

_MUCH = 10_000
"""Number of good samples after which it is reported again."""


class Malformed:
    """Counts lines or payloads that are not understood.

    Parameters
    ----------
    what : str
                What is counted, such as ``line``.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._count, self._first = 0, ""
        self._n_good = _MUCH

    def note(self, text: str, reason: str) -> None:
        """Count one."""
        if not self._count:
            self._first = f"malformed {self._what} {text[:60]!r}: {reason}"
        self._count += 1

    def events(self, n_good: int, time: float | None = None) -> tuple[Event, ...]:
        """An event for those since the last call, in which `n_good` good samples came.

        Parameters
        ----------
        n_good : int
        time : float, optional
                    Instant of the last good sample [s].
        """
        self._n_good += n_good
        if not self._count:
            return ()
        is_silent = self._n_good < _MUCH
        event = Event(EventKind.MALFORMED, self._first, time, self._count, is_silent)
        self._count = self._n_good = 0
        return (event,)
