"""The live view of a stream on a terminal: state, last samples, last windows, counts, events."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from datetime import datetime
from textwrap import wrap

import numpy as np
from rich.console import Console, ConsoleOptions, Group, RenderResult
from rich.live import Live
from rich.text import Text

from hydrofdi.api.monitoring.lines import Condition, Event, EventKind, Line, WindowLine
from hydrofdi.cli.monitor.watched import Watched
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import limits_text, score_text
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import percent, percentage, plain, readable_unit
from hydrofdi.units import convert

_FRAMES_IN_A_SECOND = 4.0
_FIRST_DATE = 1e9
"""Instants above this count from 1970 [s]; smaller ones count from the start of the machine."""
_MOST_ALARMS = 10
"""Most alarms whose instants are listed in the summary."""
_STYLES = {
    Condition.HEALTHY: "bold black on green",
    Condition.ALARM: "bold bright_white on red",
    Condition.UNKNOWN: "bold black on yellow",
}
_PREFIXES = {EventKind.ALARM_RAISED: "ALARM, ", EventKind.ALARM_CLEARED: "alarm cleared, "}
_COUNTED = {
    EventKind.GAP: ("gap", "gaps"),
    EventKind.DUPLICATE: ("duplicate", "duplicates"),
    EventKind.TIME_RAN_BACK: ("out-of-order sample", "out-of-order samples"),
    EventKind.MALFORMED: ("malformed", "malformed"),
    EventKind.DROPPED: ("dropped", "dropped"),
    EventKind.DISCONNECTED: ("disconnection", "disconnections"),
}
"""Kind of event that is counted → singular and plural of its name."""


class LiveView:
    """A sink that fills the terminal, and leaves a summary when it is closed.

    Parameters
    ----------
    file : DetectorFile
    source : str
        Name of the source.
    console : Console
        A terminal.
    """

    def __init__(self, file: DetectorFile, source: str, console: Console) -> None:
        self.watched = Watched(file, source)
        self._lock = threading.Lock()
        self._console = console
        self._live = Live(self, console=console, screen=True, refresh_per_second=_FRAMES_IN_A_SECOND)

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take samples and lines; the screen is updated a few times a second."""
        with self._lock:
            self.watched.take(chunk, lines)
        if not self._live.is_started:
            self._live.start(refresh=True)
        return ()

    def close(self) -> None:
        """Restore the terminal, and print the summary."""
        if not self._live.is_started:
            return
        self._live.stop()
        for line in summary_lines(self.watched):
            self._console.print(line, soft_wrap=True, markup=False, highlight=False)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The present screen."""
        with self._lock:
            lines = screen_lines(self.watched, console.width, console.height, is_ascii=options.ascii_only)
        yield Group(*lines)


def screen_lines(watched: Watched, width: int, height: int, *, is_ascii: bool = False) -> list[Text]:
    """All lines of the view, at most as many as the terminal has; the windows get what the others leave."""
    condition = Condition.UNKNOWN if watched.is_silent else watched.condition
    badge = "NO DATA" if watched.is_silent else condition.upper()
    flow = f"{watched.arrivals.rate:,.0f} samples/s"
    flow += "" if watched.time is None else f", lag {duration_text(watched.arrivals.lag)}"
    source, room = watched.source, max(width - len(flow) - 2, 2)
    source = source if len(source) <= room else f"…{source[1 - room :]}"
    head = [
        Text.assemble((source, "bold"), " " * max(width - len(source) - len(flow), 1), flow),
        Text.assemble((f" {badge} ", _STYLES[condition]), f" {_state(watched)}"),
        *_folded(_reading(watched), width, most=2),
        Text(f"Last {duration_text(watched.n_tail / watched.file.sampling_frequency)} of samples", "bold"),
        *map(Text, _channels(watched)),
    ]
    counts = "; ".join((_windows(watched), *_faults(watched), *_defects(watched)))
    foot = [
        Text("Counts and promise", "bold"),
        *_folded(counts, width, most=3),
        *_folded(_promise(watched.file), width, most=2),
    ]
    newest = [*map(Text, wrap(event_text(watched.events[-1]), width))] if watched.events else []
    free = height - len(head) - len(foot) - len(newest) - 2
    windows = (
        [_window(watched.file, line) for line in list(watched.windows)[-max(free, 0) :]] if free > 0 else []
    )
    older = [Text(event_text(event)) for event in list(watched.events)[:-1]]
    older = older[len(older) - max(min(free - len(windows), len(older)), 0) :]
    lines = [*head, Text(f"Last {judged_noun(watched.file)}s", "bold"), *windows, *foot]
    lines += [Text("Events (Ctrl-C ends)", "bold"), *older, *newest]
    return [_fitting(line, width, is_ascii) for line in lines[:height]]


def _fitting(line: Text, width: int, is_ascii: bool) -> Text:
    """A line that fits the width and the characters of the terminal."""
    if is_ascii:
        line = Text(line.plain.encode("ascii", "replace").decode(), spans=line.spans, style=line.style)
    line.truncate(width)
    return line


def _folded(text: str, width: int, most: int) -> list[Text]:
    return [Text(line) for line in wrap(text, width, max_lines=most, placeholder=" …")]


def _channels(watched: Watched) -> Iterator[str]:
    """The last value of each channel, and the range of its last samples."""
    for channel, values in watched.tails.items():
        unit = readable_unit(channel.unit, float(np.nanmax(np.abs(values), initial=0.0)))
        shown = values * convert(1.0, unit) if unit != channel.unit else values
        finite = shown[np.isfinite(shown)]
        span = f"{plain(finite.min(), 3)} to {plain(finite.max(), 3)}" if finite.size else "no numbers"
        yield f"{channel.symbol:>4} {plain(float(shown[-1]), 3):>9} {unit}, {span}"


def _window(file: DetectorFile, line: WindowLine) -> Text:
    verdict = line.verdict
    score = "no number" if verdict.score is None else score_text(verdict.score, file)
    if verdict.fault is not None:
        what, style = f"not judged, {verdict.fault.kind}", "yellow"
    else:
        what, style = ("beyond the limit", "bold red") if verdict.alarm else ("within the limit", "")
    return Text(f"{instant_text(line.end):>12}  {score:>12}  {what}{_chart(line)}", style)


def _state(watched: Watched) -> str:
    """The text beside the condition: its beginning, or why it is unknown."""
    if watched.is_silent:
        return _silence(watched)
    if watched.since is None:
        return f"no {judged_noun(watched.file)} was judged yet"
    lasted = max((watched.time or 0.0) - watched.since, 0.0)
    return f"since {instant_text(watched.since)} ({duration_text(lasted)})"


def _silence(watched: Watched) -> str:
    silence = duration_text(round(watched.arrivals.silence, 1))
    connection = "disconnected, " if watched.is_connected is False else ""
    if watched.n_unread:
        return f"{connection}no sample could be read: {watched.n_unread:,} malformed"
    if watched.time is None:
        return f"{connection}waiting for samples for {silence}"
    return f"{connection}no samples for {silence}; last condition: {watched.condition}"


def _reading(watched: Watched) -> str:
    """The last window: score, margin and chart, or why it is not judged; or why there is no window."""
    file = watched.file
    name = ".".join(part for part in (file.config.indicator, file.config.output) if part)
    if watched.is_silent and watched.n_unread:
        return watched.unread_text
    if not watched.windows:
        return f"{name}: alarm {limits_text(file)}"
    line = watched.windows[-1]
    verdict = line.verdict
    score = "has no number" if verdict.score is None else score_text(verdict.score, file)
    if verdict.fault is not None:
        beyond = ", beyond its limit" if verdict.is_beyond else ""
        return f"{name} {score}{beyond}; not judged, {verdict.fault.kind}: {verdict.fault.message}"
    margin = "" if verdict.margin is None else f", margin {_signed(verdict.margin)} spreads"
    doubt = f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
    return f"{name} {score}; alarm {limits_text(file)}{margin}{_chart(line)}{doubt}"


def _chart(line: WindowLine) -> str:
    """The statistic of the control chart, and its limit."""
    if line.chart is None or line.chart.statistic is None:
        return ""
    return f", chart {plain(line.chart.statistic, 3)} of {plain(line.chart.limit, 3)}"


def _signed(value: float) -> str:
    return f"{value:+,.0f}" if abs(value) >= 99.5 else f"{value:+.2g}"


def judged_noun(file: DetectorFile) -> str:
    """The noun for what is judged."""
    return "window" if file.n_sample else "estimate"


def _windows(watched: Watched) -> str:
    """The numbers of judged windows, of windows beyond the limit, and of raised alarms."""
    judged = f"{counted(watched.n_judged, judged_noun(watched.file))} judged"
    n_alarm = watched.counts[EventKind.ALARM_RAISED]
    return f"{judged}, {watched.n_beyond:,} beyond the limit, {counted(n_alarm, 'alarm')}"


def _faults(watched: Watched) -> Iterator[str]:
    """The number of windows that were not judged, by kind of fault."""
    if watched.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in watched.faults.most_common())
        yield f"{watched.faults.total():,} not judged ({kinds})"


def _defects(watched: Watched) -> Iterator[str]:
    """The numbers of defects of the stream, by kind."""
    for kind, (one, several) in _COUNTED.items():
        if n := watched.counts[kind]:
            yield f"{n:,} {one if n == 1 else several}"


def _promise(file: DetectorFile) -> str:
    """The promise of the detector, and the records behind it."""
    basis, noun = file.basis, judged_noun(file)
    groups = f" of {counted(basis.n_group, 'group')}" if basis.n_group else ""
    rests = f"from {counted(basis.n_window, f'healthy {noun}')}{groups}"
    if file.chart is not None and file.config.chart is not None:
        wanted = duration_text(file.config.chart.false_alarm_every)
        least, most = file.chart.interval
        upper = "no upper end" if most is None else duration_text(most)
        return (
            f"Promise: one false alarm in {wanted} of operation ({duration_text(least)} to {upper}), {rests}"
        )
    low, high = file.limits.interval
    wanted = percent(file.limits.false_alarm_rate)
    ends = f"{percentage(low)} to {percent(high)}"
    return f"Promise: {wanted} of healthy {noun}s lie beyond the limit ({ends}), {rests}"


def event_text(event: Event) -> str:
    """An event as a line."""
    instant = "" if event.time is None else f"{instant_text(event.time)}: "
    return f"{instant}{_PREFIXES.get(event.kind, '')}{event.text}"


def instant_text(time: float) -> str:
    """An instant on the clock of a stream [s]: local time if it counts from 1970."""
    if time < _FIRST_DATE:
        return f"{time:,.1f} s"
    instant = datetime.fromtimestamp(time)
    is_today = instant.date() == datetime.now().date()
    return f"{instant:%H:%M:%S}" if is_today else f"{instant:%Y-%m-%d %H:%M:%S}"


def duration_text(duration: float) -> str:
    """A duration [s] such as ``12 s``, ``3 min 20 s``, ``2 h 5 min`` or ``3 d 4 h``."""
    if duration < 9.95:
        return f"{round(duration, 3 if duration < 0.1 else 1):g} s"
    seconds = round(duration)
    for unit, size, smaller, part in (("d", 86400, "h", 3600), ("h", 3600, "min", 60), ("min", 60, "s", 1)):
        if seconds >= size:
            rest = seconds % size // part
            return f"{seconds // size} {unit} {rest} {smaller}" if rest else f"{seconds // size} {unit}"
    return f"{seconds} s"


def summary_lines(watched: Watched) -> Iterator[str]:
    """The condition at the end, and the counts: windows, alarms with instants, faults, events."""
    condition = str(watched.condition)
    if watched.since is not None:
        condition += f" since {instant_text(watched.since)}"
    yield f"{watched.source}, watched for {duration_text(watched.arrivals.age)}; at the end: {condition}"
    yield _windows(watched)
    if watched.alarms:
        told = list(watched.alarms)[-_MOST_ALARMS:]
        before = watched.counts[EventKind.ALARM_RAISED] - len(told)
        more = f"; {before:,} before" if before else ""
        yield f"alarms raised at {', '.join(map(instant_text, told))}{more}"
    yield from _faults(watched)
    if defects := ", ".join(_defects(watched)):
        yield defects
