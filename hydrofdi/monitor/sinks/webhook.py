"""Events posted to a web address, in a thread of their own."""

from __future__ import annotations

import json
import socket
import uuid
from collections import deque
from collections.abc import Sequence
from threading import Condition, Thread

from hydrofdi.monitor.line_record import line_record
from hydrofdi.monitor.lines import Event, EventKind, Line
from hydrofdi.monitor.sinks.posting import NotReachedError, NotTakenError, Poster
from hydrofdi.monitor.sinks.webhook_config import WebhookConfig, doubts, shown_url
from hydrofdi.records.streams import Chunk

CAPACITY = 1_000
"""Most events that wait; further ones are lost."""

_LONGEST_WAIT = 120.0
_FAREWELL = 3.0


class WebhookSink:
    """Posts events in order; if the server cannot accept one now, it is posted again.

    Parameters
    ----------
    config : WebhookConfig
    capacity : int
                Most events that wait.
    first_wait : float
                Wait before the second attempt [s]; it doubles up to two minutes.

    Raises
    ------
    ConfigError
        The configuration cannot be used.
    """

    def __init__(self, config: WebhookConfig, *, capacity: int = CAPACITY, first_wait: float = 1.0) -> None:
        self._config, self._capacity, self._first_wait = config, capacity, first_wait
        self._poster, self._place = Poster(config), shown_url(config.url)
        self._waiting: deque[tuple[str, bytes]] = deque()
        self._said = [Event(EventKind.INSECURE, doubt) for doubt in doubts(config)]
        self._is_full = self._is_closing = False
        self._changed = Condition()
        self._thread = Thread(target=self._run, name="webhook", daemon=True)
        self._thread.start()

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Queue the events to post; never waits."""
        wanted = [line for line in lines if isinstance(line, Event) and self._is_wanted(line)]
        with self._changed:
            n_lost = sum(not self._queued(line) for line in wanted)
            said, self._said = self._said, []
            self._changed.notify()
        return [*said, *self._losses(len(wanted), n_lost)]

    def close(self) -> None:
        """Post what is left, within three seconds."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        self._thread.join(_FAREWELL)

    def _is_wanted(self, event: Event) -> bool:
        return event.kind in self._config.events and not event.is_silent

    def _queued(self, event: Event) -> bool:
        if len(self._waiting) >= self._capacity:
            return False
        document = {"machine": self._config.machine or socket.gethostname(), **line_record(event)}
        text = json.dumps(document, ensure_ascii=False, allow_nan=False)
        self._waiting.append((str(uuid.uuid4()), text.encode()))
        return True

    def _losses(self, n_wanted: int, n_lost: int) -> list[Event]:
        if not n_lost:
            self._is_full = self._is_full and not n_wanted
            return []
        was_full, self._is_full = self._is_full, True
        text = f"events for {self._place} are lost: {self._capacity} are already waiting"
        return [Event(EventKind.DROPPED, text, None, n_lost, is_silent=was_full)]

    def _run(self) -> None:
        wait, is_reached = self._first_wait, True
        while (first := self._first()) is not None:
            try:
                self._poster.post(first[1], first[0])
            except NotReachedError as error:
                if is_reached:
                    self._say(EventKind.DISCONNECTED, f"{self._place}: {error}; its events wait")
                is_reached = False
                if self._is_ended_after(wait):
                    return
                wait = min(2 * wait, _LONGEST_WAIT)
                continue
            except NotTakenError as error:
                self._say(EventKind.DROPPED, f"{self._place}: an event is lost: {error}")
            if not is_reached:
                self._say(EventKind.CONNECTED, f"{self._place} accepts events again")
            wait, is_reached = self._first_wait, True
            self._waiting.popleft()

    def _first(self) -> tuple[str, bytes] | None:
        """The next event to post; None at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._is_closing)
            return self._waiting[0] if self._waiting else None

    def _is_ended_after(self, wait: float) -> bool:
        with self._changed:
            return self._changed.wait_for(lambda: self._is_closing, wait)

    def _say(self, kind: EventKind, text: str) -> None:
        with self._changed:
            self._said.append(Event(kind, text))
