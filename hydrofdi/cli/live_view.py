"""The live view of a stream on a terminal: state, last values, counts, promise, last windows, events."""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from datetime import datetime

from rich.console import Console, ConsoleOptions, RenderResult
from rich.live import Live
from rich.text import Text

from hydrofdi.api.detectors.promise import promise_text
from hydrofdi.api.detectors.windows import Condition, Event, EventKind, Line, WindowLine
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import plain, shown_quantity, time_text

_FRAMES_IN_A_SECOND = 4.0
_FIRST_DATE = 1e9
"""Instants above this count from 1970 [s]; smaller ones count from the start of the machine."""
_MOST_LINES, _MOST_ALARMS = 50, 10
"""Windows and events that are kept, and alarms whose instants the summary lists."""
_SILENT_AFTER = 5.0
"""Least time without samples after which the last condition is out of date [s]."""
_STYLES = {
    Condition.HEALTHY: "bold black on green",
    Condition.ALARM: "bold bright_white on red",
    Condition.UNKNOWN: "bold black on yellow",
}
_COUNTED = (EventKind.GAP, EventKind.DUPLICATE, EventKind.TIME_RAN_BACK, EventKind.MALFORMED,
            EventKind.DROPPED, EventKind.DISCONNECTED)  # fmt: skip


class LiveView:
    """A sink that fills the terminal, and leaves a summary when it is closed. Memory is bounded."""

    def __init__(self, file: DetectorFile, source: str, console: Console) -> None:
        self._file, self._source, self._console = file, source, console
        self._noun = "window" if file.n_sample else "estimate"
        self._lock = threading.Lock()
        self._live = Live(self, console=console, screen=True, refresh_per_second=_FRAMES_IN_A_SECOND)
        self._opened = self._arrived = time.monotonic()
        self._condition, self._since = Condition.UNKNOWN, 0.0
        self._samples: Chunk | None = None
        self._is_connected = True
        self._unread: list[str] = []
        self._windows = deque[WindowLine](maxlen=_MOST_LINES)
        self._events = deque[Event](maxlen=_MOST_LINES)
        self._alarms = deque[float](maxlen=_MOST_ALARMS)
        self._counts: Counter[str] = Counter()
        self._faults: Counter[str] = Counter()

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take samples and lines; the screen is updated a few times a second."""
        with self._lock:
            self._take(chunk, lines)
        if not self._live.is_started:
            self._live.start(refresh=True)
        return ()

    def close(self) -> None:
        """Restore the terminal, and print the summary."""
        if self._live.is_started:
            self._live.stop()
            for line in self.summary():
                self._console.print(line, soft_wrap=True)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The present screen; the terminal cuts off what does not fit, the oldest windows first."""
        with self._lock:
            yield from self._lines()

    def _take(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        if chunk is not None and (readable := chunk.readable).n_time:
            self._samples, self._arrived = readable, time.monotonic()
            self._is_connected, self._unread = True, []
            self._counts["unread"] = 0
        if chunk is not None and chunk.unread:
            self._unread = [*self._unread, *chunk.unread.values()][:1]
            self._counts["unread"] += len(chunk.unread)
        for line in lines:
            if isinstance(line, Event):
                self._take_event(line)
                continue
            if line.condition is not self._condition:
                self._condition, self._since = line.condition, line.end
            if line.verdict.fault is not None:
                self._faults[line.verdict.fault.kind] += 1
            else:
                self._counts.update(judged=1, beyond=int(bool(line.verdict.alarm)))
            self._windows.append(line)

    def _take_event(self, event: Event) -> None:
        self._counts[event.kind] += 0 if event.is_end else event.count
        if event.kind in (EventKind.CONNECTED, EventKind.DISCONNECTED):
            self._is_connected = event.kind is EventKind.CONNECTED
        if event.kind is EventKind.ALARM_RAISED and event.time is not None:
            self._alarms.append(event.time)
        if not event.is_silent:
            self._events.append(event)

    def _lines(self) -> Iterator[Text]:
        state, style = self._state()
        yield Text(self._source, "bold", no_wrap=True)
        yield Text.assemble((f" {state.partition(' ')[0]} ", style), f" {state.partition(' ')[2]}")
        if self._samples is not None:
            values = ((channel, samples[-1]) for channel, samples in self._samples.channels.items())
            shown = (f"{each.symbol} {shown_quantity(float(value), each.unit)}" for each, value in values)
            yield Text(", ".join(shown))
        yield Text(f"{self._file.score_name}: alarm {self._file.limits_text}")
        yield Text("; ".join(self._counted()))
        yield Text(promise_text(self._file))
        yield Text("Events (Ctrl-C ends)", "bold")
        yield from (Text(_event_text(event)) for event in list(self._events)[-3:])
        yield Text(f"Last {self._noun}s", "bold")
        yield from (self._window(line) for line in reversed(self._windows))

    def _state(self) -> tuple[str, str]:
        """The condition, with its beginning or why it is unknown; and its style."""
        silence = time.monotonic() - self._arrived
        patience = max(_SILENT_AFTER, 2.0 * self._file.n_sample / self._file.sampling_frequency)
        if self._samples is not None and self._is_connected and silence <= patience:
            began = f"since {_instant_text(self._since)}" if self._windows else f"no {self._noun} judged yet"
            return f"{self._condition.upper()} {began}", _STYLES[self._condition]
        why = "" if self._is_connected else "disconnected, "
        if self._unread:
            why += f"{self._counts['unread']:,} malformed: {self._unread[0]}"
        elif self._samples is None:
            why += f"waiting for samples for {time_text(silence)}"
        else:
            why += f"no samples for {time_text(silence)}; last condition: {self._condition}"
        return f"SILENT {why}", _STYLES[Condition.UNKNOWN]

    def _window(self, line: WindowLine) -> Text:
        verdict = line.verdict
        score = "no number" if verdict.score is None else self._file.score_text(verdict.score)
        beyond = "beyond the limit" if verdict.is_beyond or verdict.alarm else "within the limit"
        what, style = beyond, "bold red" if verdict.alarm else ""
        if verdict.fault is not None:
            what, style = f"{beyond}; not judged, {verdict.fault.kind}: {verdict.fault.message}", "yellow"
        if line.chart is not None and line.chart.statistic is not None:
            what += f", chart {plain(line.chart.statistic, 3)} of {plain(line.chart.limit, 3)}"
        if verdict.doubt:
            what += f"; doubtful: {verdict.doubt}"
        return Text(f"{_instant_text(line.end):>12}  {score:>12}  {what}", style, no_wrap=True)

    def _counted(self) -> Iterator[str]:
        """The numbers of windows, of alarms, and of what is wrong with the stream."""
        judged, alarms = (self._counts[kind] for kind in ("judged", EventKind.ALARM_RAISED))
        beyond = f"{self._counts['beyond']:,} beyond the limit"
        yield f"{counted(judged, self._noun)} judged, {beyond}, {counted(alarms, 'alarm')}"
        if self._faults:
            kinds = ", ".join(f"{kind} {n:,}" for kind, n in self._faults.most_common())
            yield f"{self._faults.total():,} not judged ({kinds})"
        yield from (f"{kind.replace('_', ' ')} {n:,}" for kind in _COUNTED if (n := self._counts[kind]))

    def summary(self) -> Iterator[str]:
        """The condition at the end, and the counts."""
        lasted = time_text(time.monotonic() - self._opened)
        yield f"{self._source}, watched for {lasted}; at the end: {self._condition}"
        yield from self._counted()
        if self._alarms:
            yield f"the last alarms were raised at {', '.join(map(_instant_text, self._alarms))}"


def _event_text(event: Event) -> str:
    kind = event.kind.replace("_", " ")
    named = f"{kind.upper() if kind.startswith('alarm') else kind}, {event.text}"
    return named if event.time is None else f"{_instant_text(event.time)}: {named}"


def _instant_text(instant: float) -> str:
    """An instant on the clock of a stream [s]: local time if it counts from 1970."""
    if instant < _FIRST_DATE:
        return f"{instant:,.1f} s"
    return f"{datetime.fromtimestamp(instant):%Y-%m-%d %H:%M:%S}"
