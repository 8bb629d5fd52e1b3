"""Totals of malformed and lost samples, reported at the end."""

from __future__ import annotations

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.sources import Reading

_WORDS = {EventKind.MALFORMED: "malformed", EventKind.DROPPED: "lost"}


class SourceTotals:
    """Counts samples, and lines or messages that are malformed or lost."""

    def __init__(self) -> None:
        self._n_sample = self._n_unread = 0
        self._first: dict[EventKind, Event] = {}
        self._count = dict.fromkeys(_WORDS, 0)

    def note(self, reading: Reading) -> None:
        """Count a reading."""
        if reading.chunk is not None:
            self._n_sample += reading.chunk.readable.n_time
            self._n_unread += len(reading.chunk.unread)
        for event in reading.events:
            if event.kind in _WORDS:
                self._first.setdefault(event.kind, event)
                self._count[event.kind] += event.count

    @property
    def is_unreadable(self) -> bool:
        """Whether something arrived, but no sample."""
        return not self._n_sample and self._n_unread + self._count[EventKind.MALFORMED] > 0

    def events(self) -> list[Event]:
        """The totals of events that were not all reported."""
        return [
            Event(
                kind,
                f"{self._count[kind]:,} {_WORDS[kind]} in total, the first: {first.text}",
                None,
                self._count[kind],
                is_end=True,
            )
            for kind, first in self._first.items()
            if self._count[kind] > first.count
        ]
