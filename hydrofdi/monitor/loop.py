"""The loop of a monitor, from its source to its sinks. It continues from a stored state."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from enum import StrEnum

from hydrofdi.errors import StoreError
from hydrofdi.monitor.lines import Line, Sink, WindowLine, is_said
from hydrofdi.monitor.sources import Position, StreamSource
from hydrofdi.monitor.state import StateFile, Stored, WindowLog
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.streams import Chunk, Event, EventKind, State

PATIENCE = 0.2
"""Longest wait for a source before the loop checks whether to stop [s]."""

STORE_EVERY = 1.0
"""Shortest time from one storing of the state to the next, while lines keep coming [s]."""


class Ending(StrEnum):
    """Why a monitor ended."""

    OVER = "the stream is over"
    UNJUDGED = "the stream is over, and no window was judged"
    STOPPED = "it received a request to stop"
    OUTPUT_CLOSED = "its output is no longer read"


def monitor(
    watch: Watch,
    source: StreamSource,
    sinks: Sequence[Sink] = (),
    *,
    state_file: StateFile | None = None,
    log: WindowLog | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Ending:
    """Watch a stream until it is over, or a stop is requested.

    If a step has lines, they go to the sinks. Then the state is stored, with the lines, at most once a
    second; then they go to the log, and the source may discard the samples. After a crash, the log has each
    window once; a sink may receive the lines since the last storing twice, with the same numbers.
    """
    with ExitStack() as stack:
        if state_file is not None:
            stack.enter_context(state_file.locked())
        for sink in sinks:
            stack.callback(sink.close)
        stack.callback(source.close)
        if log is not None:
            stack.callback(log.close)
        return _Monitor(watch, source, sinks, state_file, log).run(stop)


@dataclass
class _Monitor:
    _watch: Watch
    _source: StreamSource
    _sinks: Sequence[Sink]
    _state_file: StateFile | None
    _log: WindowLog | None
    _pending: list[Line] = field(default_factory=list)
    _is_unjudged: bool = True
    _waits: bool = False
    _is_unstored: bool = False
    _tried: float = -STORE_EVERY
    _n_lost: int = 0

    def __post_init__(self) -> None:
        self._state = self._watch.start()
        self._delivered: tuple[State, Position] = self._state, {}

    def run(self, stop: Callable[[], bool]) -> Ending:
        try:
            self._deliver(None, [self._begin()])
            while not self._source.is_over:
                if stop():
                    return self._end(Ending.STOPPED)
                self._step(self._source.read(PATIENCE))
            return self._end(Ending.UNJUDGED if self._is_unjudged else Ending.OVER)
        except Exception as error:
            if self._waits:
                with suppress(StoreError):
                    self._store()
            if isinstance(error, BrokenPipeError):
                return Ending.OUTPUT_CLOSED
            raise

    def _begin(self) -> Event:
        """Restore the stored state; open the log and the source."""
        stored = None if self._state_file is None else self._state_file.read()
        if self._log is not None:
            self._log.open({} if stored is None else stored.log)
        self._source.open({} if stored is None else stored.position)
        if stored is None:
            return Event(EventKind.STARTED, f"watches {self._source.name}")
        self._state, self._is_unjudged = stored.state, not self._watch.next_number(stored.state)
        if not stored.position:
            self._state = self._watch.resume(stored.state, may_repeat=self._source.may_repeat_all)
        text = f"watches {self._source.name} again, from window {self._watch.next_number(self._state)} on"
        return Event(EventKind.RESUMED, text)

    def _step(self, chunk: Chunk | None) -> None:
        events = self._source.events
        happened = [events.popleft() for _ in range(len(events))]
        self._n_lost += sum(event.count for event in happened if event.kind is EventKind.DROPPED)
        lines: list[Line] = [*happened]
        if chunk is not None and chunk.n_time:
            self._state, more = self._watch.step(self._state, chunk)
            alarms = [line.verdict.alarm for line in more if isinstance(line, WindowLine)]
            self._is_unjudged = self._is_unjudged and alarms.count(None) == len(alarms)
            lines += more
        self._deliver(chunk, lines)

    def _end(self, ending: Ending) -> Ending:
        """Deliver the last lines; if no restart will continue, end the episodes."""
        n_lost, lines = self._n_lost, list[Line]()
        if n_lost:
            text = f"{n_lost:,} samples or messages were lost in total"
            lines.append(Event(EventKind.DROPPED, text, None, n_lost, is_end=True))
        if ending is not Ending.STOPPED or self._state_file is None:
            self._state, more = self._watch.end(self._state)
            lines += more
        self._tried = -STORE_EVERY  # what is last is stored at once
        self._deliver(None, [*lines, Event(EventKind.STOPPED, f"stopped: {ending}")])
        return ending

    def _deliver(self, chunk: Chunk | None, lines: list[Line]) -> None:
        """Pass lines to the sinks, the state and the log, in this order, so that no line is lost."""
        lines = [*self._pending, *lines]
        self._pending = [line for sink in self._sinks for line in sink.put(chunk, lines)]
        if self._log is not None:
            self._log.take(lines)
        self._delivered = self._state, self._source.position
        self._waits = self._waits or any(map(is_said, lines))
        is_due = time.monotonic() >= self._tried + STORE_EVERY
        if not (self._source.wants_confirmation or (self._waits and is_due)):
            return
        self._tried = time.monotonic()
        try:
            self._store()
            self._source.confirm()
        except StoreError as error:
            self._note(error)
        else:
            self._note(None)

    def _store(self) -> None:
        """Store all that was delivered."""
        log = {} if self._log is None else self._log.position
        if self._state_file is not None:
            self._state_file.write(Stored(*self._delivered, log))
        if self._log is not None:
            self._log.write()
        self._waits = False

    def _note(self, error: StoreError | None) -> None:
        """Report once that the state cannot be stored, and once that it can again."""
        if error is not None and not self._is_unstored:
            self._pending.append(Event(EventKind.NOT_STORED, f"continues without storing its state: {error}"))
        if error is None and self._is_unstored:
            self._pending.append(Event(EventKind.NOT_STORED, "stores its state again", is_end=True))
        self._is_unstored = error is not None
