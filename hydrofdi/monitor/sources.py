"""What sources of streams have in common."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hydrofdi.monitor.configuration import Address
from hydrofdi.records.streams import Chunk, Event

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
