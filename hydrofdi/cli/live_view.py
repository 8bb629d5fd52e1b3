"""The live view of a stream on a terminal: state, last values, counts, promise, events, last windows."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from datetime import datetime

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import Condition, Line, WindowLine
from hydrofdi.detectors.promise import promise_text
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.settings.messages import counted, plain, shown_quantity, time_text

_FRAME = 0.25
"""Time between frames [s]."""
_SILENT_AFTER = 5.0
"""Least time without samples after which the last condition is out of date [s]."""
_STYLES = {"HEALTHY": "bold black on green", "ALARM": "bold bright_white on red"}
_COUNTED = ("gap", "duplicate", "time_ran_back", "malformed", "dropped", "disconnected")


class LiveView:
    """A view that fills the terminal, and leaves a summary when it is closed. Memory is bounded."""

    def __init__(self, file: DetectorFile, source: str, console: Console) -> None:
        self._file, self._source, self._console = file, source, console
        self._live = Live(console=console, screen=True, auto_refresh=False)
        self._opened = self._arrived = time.monotonic()
        self._drawn = self._opened - _FRAME
        self._samples: Chunk | None = None
        self._condition, self._since, self._is_connected = Condition.UNKNOWN, 0.0, True
        self._windows, self._events = deque[WindowLine](maxlen=50), deque[Event](maxlen=3)
        self._counts = Counter[str]()

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        """Take samples and lines; the screen is updated a few times a second."""
        self._take(chunk, lines)
        if not self._live.is_started:
            self._live.start()
        if time.monotonic() - self._drawn >= _FRAME:
            self._drawn = time.monotonic()
            self._live.update(Group(*self._screen()), refresh=True)

    def close(self) -> None:
        """Restore the terminal, and print the condition at the end, and the counts."""
        if self._live.is_started:
            self._live.stop()
            lasted = time_text(time.monotonic() - self._opened)
            ended = f"{self._source}, watched for {lasted}; at the end: {self._condition}"
            for line in (ended, *self._counted()):
                self._console.print(line, soft_wrap=True)

    def _take(self, chunk: Chunk | None, lines: Sequence[Line]) -> None:
        if chunk is not None and (readable := chunk.readable).n_time:
            self._samples, self._arrived, self._is_connected = readable, time.monotonic(), True
        for line in lines:
            if isinstance(line, Event):
                self._counts[line.kind] += 0 if line.is_end else line.count
                is_lost, is_made = line.kind is EventKind.DISCONNECTED, line.kind is EventKind.CONNECTED
                self._is_connected = is_made or (self._is_connected and not is_lost)
                self._events.extend([] if line.is_silent else [line])
                continue
            if line.condition is not self._condition:
                self._condition, self._since = line.condition, line.end
            self._counts[
                "judged" if (fault := line.verdict.fault) is None else f"not judged, {fault.kind}"
            ] += 1
            self._counts["beyond"] += bool(line.verdict.alarm)
            self._windows.append(line)

    def _screen(self) -> Iterator[Text | Table]:
        """The terminal cuts off what does not fit, the oldest windows first."""
        yield from self._lines()
        windows = Table.grid(padding=(0, 2))
        for line in reversed(self._windows):
            verdict = line.verdict
            score = "no number" if verdict.score is None else self._file.score_text(verdict.score)
            what = ["beyond the limit" if verdict.is_beyond or verdict.alarm else "within the limit"]
            what += [str(verdict.leak)] if line.alarm and verdict.leak else []
            if verdict.fault is not None:
                what.append(f"not judged, {verdict.fault.kind}: {verdict.fault.message}")
            if line.chart is not None and line.chart.statistic is not None:
                what.append(f"chart {plain(line.chart.statistic, 3)} of {plain(line.chart.limit, 3)}")
            if verdict.doubt:
                what.append(f"doubtful: {verdict.doubt}")
            style = "yellow" if verdict.fault else "bold red" if verdict.alarm else ""
            windows.add_row(_instant_text(line.end), score, Text("; ".join(what), no_wrap=True), style=style)
        yield windows

    def _lines(self) -> Iterator[Text]:
        badge, why = self._state()
        yield Text(self._source, "bold", no_wrap=True)
        yield Text.assemble((f" {badge} ", _STYLES.get(badge, "bold black on yellow")), f" {why}")
        if self._samples is not None:
            last = ((each, float(samples[-1])) for each, samples in self._samples.channels.items())
            yield Text(", ".join(f"{each.symbol} {shown_quantity(value, each.unit)}" for each, value in last))
        limits = f"{self._file.score_name}: alarm {self._file.alarm_text}"
        yield Text("\n".join((limits, "; ".join(self._counted()), promise_text(self._file))))
        yield Text("Events (Ctrl-C ends)", "bold")
        for event in self._events:
            kind = event.kind.replace("_", " ")
            named = f"{kind.upper() if kind.startswith('alarm') else kind}, {event.text}"
            yield Text(named if event.time is None else f"{_instant_text(event.time)}: {named}")
        yield Text("Last windows", "bold")

    def _state(self) -> tuple[str, str]:
        """The condition, with its beginning; or that it is not known now, and why."""
        silence = time.monotonic() - self._arrived
        patience = max(_SILENT_AFTER, 2.0 * self._file.n_sample / self._file.sampling_frequency)
        if self._samples is not None and self._is_connected and silence <= patience:
            began = f"since {_instant_text(self._since)}" if self._windows else "no window judged yet"
            return self._condition.upper(), began
        why = "" if self._is_connected else "disconnected, "
        if self._samples is None:
            return "SILENT", f"{why}waiting for samples for {time_text(silence)}"
        return "SILENT", f"{why}no samples for {time_text(silence)}; last condition: {self._condition}"

    def _counted(self) -> Iterator[str]:
        """The numbers of windows, of alarms, and of what is wrong with the stream."""
        judged, alarms = (self._counts[kind] for kind in ("judged", EventKind.ALARM_RAISED))
        beyond = f"{self._counts['beyond']:,} beyond the limit"
        yield f"{counted(judged, 'window')} judged, {beyond}, {counted(alarms, 'alarm')}"
        for kind, count in self._counts.items():
            if count and (kind in _COUNTED or kind.startswith("not judged")):
                yield f"{kind.replace('_', ' ')} {count:,}"


def _instant_text(instant: float) -> str:
    """An instant on the clock of a stream [s]: local time if it counts from 1970."""
    if instant < 1e9:
        return f"{instant:,.1f} s"
    return f"{datetime.fromtimestamp(instant):%Y-%m-%d %H:%M:%S}"
