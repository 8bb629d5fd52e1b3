"""What a source of a stream is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from hydrofdi.monitor.lines import Event
from hydrofdi.records.streams import Chunk

Position = Mapping[str, Any]
"""Where a source continues after a restart: small, and fit for JSON. Empty if it cannot go back."""


@dataclass(frozen=True)
class Reading:
    """What a source gave.

    Attributes
    ----------
    chunk : Chunk or None
        New samples; at most about 65,536, so that results come steadily.
    events : tuple of Event
        What happened meanwhile: malformed payloads, lost connections, dropped samples.
    is_over : bool
        Whether nothing will follow.
    """

    chunk: Chunk | None = None
    events: tuple[Event, ...] = ()
    is_over: bool = False


class StreamSource(Protocol):
    """A stream of samples. One thread calls its methods; sockets, event loops and other threads are its own.

    Samples that come again (after a restart, or from a broker that was not sure) need no care: the watch
    leaves out what is not later than what it has seen. A source that keeps nothing need not say so.
    """

    @property
    def name(self) -> str:
        """What a person calls it; without credentials."""
        ...

    def open(self, position: Position) -> None:
        """Begin, at a position that an earlier run has stored; empty at the first start.

        Raises
        ------
        DataError
            It cannot be used: no such file, no permission. A server that does not answer is no such case.
        """
        ...

    def read(self, timeout: float) -> Reading:
        """What has come; after `timeout` seconds without anything, an empty reading."""
        ...

    @property
    def position(self) -> Position:
        """Where to continue after all that `read` gave; nothing if it cannot go back."""
        return {}

    @property
    def may_repeat_all(self) -> bool:
        """Whether a restart without a position may bring all of the stream again, as a pipe does; a broker
        brings the last few seconds again at most."""
        return False

    @property
    def wants_confirmation(self) -> bool:
        """Whether so much was read since the last confirmation that the state should be stored now."""
        return False

    def confirm(self) -> None:
        """A state that contains all that `read` gave is stored: a broker may forget it."""
        return

    def close(self) -> None:
        """End connections, threads and files."""
        ...
