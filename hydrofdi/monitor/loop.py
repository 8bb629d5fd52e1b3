"""The loop of a monitor, from its source to its sinks. It continues from a stored state."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from enum import StrEnum

from hydrofdi.errors import StoreError
from hydrofdi.monitor.lines import Event, EventKind, Line, Sink, is_said
from hydrofdi.monitor.log import WindowLog
from hydrofdi.monitor.sources.contract import Reading, StreamSource
from hydrofdi.monitor.state import StateFile, Stored
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.streams import Chunk

PATIENCE = 0.2
"""Longest wait for a source before the loop checks whether to stop [s]."""


class Ending(StrEnum):
    """Why a monitor ended."""

    OVER = "the stream is over"
    UNREADABLE = "the stream is over, and no sample of it could be read"
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

    If a step has lines, they go to the sinks. Then the state is stored, with the lines; then they go to the
    log, and the source may discard the samples of the step. After a crash, the log has each window once; a
    sink may receive the lines of the last step twice, with the same numbers.

    Parameters
    ----------
    watch : Watch
    source : StreamSource
        This function opens and closes it.
    sinks : sequence of Sink
        This function closes them.
    state_file : StateFile, optional
        Without it, a restart begins anew.
    log : WindowLog, optional
    stop : callable
        Whether to end; called several times a second.

    Raises
    ------
    DataError
        The source cannot be used.
    StoreError
        The state is damaged, in use, or of another monitor; or the log cannot be written at the start.
    BaseException
        Any other exception of a source or a sink.
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


class _Monitor:
    def __init__(
        self,
        watch: Watch,
        source: StreamSource,
        sinks: Sequence[Sink],
        state_file: StateFile | None,
        log: WindowLog | None,
    ) -> None:
        self._watch, self._source, self._sinks = watch, source, sinks
        self._state_file, self._log = state_file, log
        self._state = watch.start()
        self._pending: list[Line] = []
        self._totals = SourceTotals()
        self._is_unstored = False

    def run(self, stop: Callable[[], bool]) -> Ending:
        try:
            self._deliver(None, [self._begin()])
            while not stop():
                reading = self._source.read(PATIENCE)
                self._step(reading)
                if reading.is_over:
                    return self._end(Ending.UNREADABLE if self._totals.is_unreadable else Ending.OVER)
            return self._end(Ending.STOPPED)
        except BrokenPipeError:
            return Ending.OUTPUT_CLOSED

    def _begin(self) -> Event:
        """Restore the stored state; open the log and the source."""
        stored = None if self._state_file is None else self._state_file.read()
        if self._log is not None:
            self._log.open({} if stored is None else stored.log)
        self._source.open({} if stored is None else stored.position)
        if stored is None:
            return Event(EventKind.STARTED, f"watches {self._source.name}")
        self._state = stored.state
        if not stored.position:
            self._state = self._watch.resume(stored.state, may_repeat=self._source.may_repeat_all)
        text = f"watches {self._source.name} again, from window {self._watch.next_number(self._state)} on"
        return Event(EventKind.RESUMED, text)

    def _step(self, reading: Reading) -> None:
        self._totals.note(reading)
        lines: list[Line] = [*reading.events]
        if reading.chunk is not None and reading.chunk.n_time:
            self._state, more = self._watch.step(self._state, reading.chunk)
            lines += more
        self._deliver(reading.chunk, lines)

    def _end(self, ending: Ending) -> Ending:
        """Deliver the last lines; if no restart will continue, end the episodes."""
        lines: list[Line] = [*self._totals.events()]
        if ending is not Ending.STOPPED or self._state_file is None:
            self._state, more = self._watch.end(self._state)
            lines += more
        self._deliver(None, [*lines, Event(EventKind.STOPPED, f"stopped: {ending}")])
        return ending

    def _deliver(self, chunk: Chunk | None, lines: list[Line]) -> None:
        """Pass lines to the sinks, the state and the log, in this order, so that no line is lost."""
        lines = [*self._pending, *lines]
        self._pending = [line for sink in self._sinks for line in sink.put(chunk, lines)]
        is_due = self._is_unstored or self._source.wants_confirmation or any(map(is_said, lines))
        if self._log is not None:
            self._log.take(lines)
        try:
            if is_due:
                self._store()
        except StoreError as error:
            self._note(error)
        else:
            self._note(None)

    def _store(self) -> None:
        log = {} if self._log is None else self._log.position
        if self._state_file is not None:
            self._state_file.write(Stored(self._state, self._source.position, log))
        if self._log is not None:
            self._log.write()
        self._source.confirm()

    def _note(self, error: StoreError | None) -> None:
        """Report once that the state cannot be stored, and once that it can again."""
        if error is not None and not self._is_unstored:
            self._pending.append(Event(EventKind.NOT_STORED, f"continues without storing its state: {error}"))
        if error is None and self._is_unstored:
            self._pending.append(Event(EventKind.NOT_STORED, "stores its state again", is_end=True))
        self._is_unstored = error is not None


_WORDS = {EventKind.MALFORMED: "malformed", EventKind.DROPPED: "lost"}


class SourceTotals:
    """Counts samples, and lines or messages that are malformed or lost."""

    def __init__(self) -> None:
        self._n_sample = self._n_unread = 0
        self._first: dict[EventKind, Event] = {}
        self._count: Counter[EventKind] = Counter()

    def note(self, reading: Reading) -> None:
        """Count a reading."""
        if reading.chunk is not None:
            self._n_sample += reading.chunk.readable.n_time
            self._n_unread += len(reading.chunk.unread)
        for event in reading.events:
            self._first.setdefault(event.kind, event)
            self._count[event.kind] += event.count

    @property
    def is_unreadable(self) -> bool:
        """Whether something arrived, but no sample."""
        return not self._n_sample and self._n_unread + self._count[EventKind.MALFORMED] > 0

    def events(self) -> Iterator[Event]:
        """The totals of events that were not all reported."""
        for kind, word in _WORDS.items():
            if (count := self._count[kind]) and count > (first := self._first[kind]).count:
                text = f"{count:,} {word} in total, the first: {first.text}"
                yield Event(kind, text, None, count, is_end=True)
