"""Texts of the live view."""

from __future__ import annotations

from datetime import datetime

from hydrofdi.api.monitoring.lines import Event, EventKind, WindowLine
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import limits_text, plain, score_text

_FIRST_DATE = 1e9
"""Instants above this count from 1970 [s]; smaller ones count from the start of the machine."""

_PREFIXES = {EventKind.ALARM_RAISED: "ALARM, ", EventKind.ALARM_CLEARED: "alarm cleared, "}


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


def state_text(watched: Watched) -> str:
    """The text beside the condition: its beginning, or why it is unknown."""
    if watched.is_silent:
        return _silence_text(watched)
    if watched.since is None:
        return f"no {judged_noun(watched.file)} was judged yet"
    lasted = max((watched.time or 0.0) - watched.since, 0.0)
    return f"since {instant_text(watched.since)} ({duration_text(lasted)})"


def _silence_text(watched: Watched) -> str:
    silence = duration_text(round(watched.arrivals.silence, 1))
    connection = "disconnected, " if watched.is_connected is False else ""
    if watched.n_unread:
        return f"{connection}no sample could be read: {watched.n_unread:,} malformed"
    if watched.time is None:
        return f"{connection}waiting for samples for {silence}"
    return f"{connection}no samples for {silence}; last condition: {watched.condition}"


def flow_text(watched: Watched) -> str:
    """Samples per second, and their delay."""
    rate = f"{watched.arrivals.rate:,.0f} samples/s"
    return rate if watched.time is None else f"{rate}, lag {duration_text(watched.arrivals.lag)}"


def reading_text(watched: Watched) -> str:
    """The last window: score, margin and chart, or why it is not judged; or why there is no window."""
    if watched.is_silent and watched.n_unread:
        return watched.unread_text
    if not watched.windows:
        return f"{score_name(watched.file)}: alarm {limits_text(watched.file)}"
    line, file = watched.windows[-1], watched.file
    verdict, name = line.verdict, score_name(watched.file)
    score = "has no number" if verdict.score is None else score_text(verdict.score, file)
    if verdict.fault is not None:
        beyond = ", beyond its limit" if verdict.is_beyond else ""
        return f"{name} {score}{beyond}; not judged, {verdict.fault.kind}: {verdict.fault.text}"
    margin = "" if verdict.margin is None else f", margin {signed(verdict.margin)} spreads"
    doubt = f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
    return f"{name} {score}; alarm {limits_text(file)}{margin}{chart_text(line)}{doubt}"


def score_name(file: DetectorFile) -> str:
    """The score as ``indicator.output``."""
    return ".".join(part for part in (file.config.indicator, file.config.output) if part)


def judged_noun(file: DetectorFile) -> str:
    """The noun for what is judged."""
    return "window" if file.n_sample else "estimate"


def chart_text(line: WindowLine) -> str:
    """The statistic of the control chart, and its limit."""
    if line.chart is None or line.chart.statistic is None:
        return ""
    return f", chart {plain(line.chart.statistic, 3)} of {plain(line.chart.limit, 3)}"


def signed(value: float) -> str:
    """A number with its sign and at least two digits."""
    return f"{value:+,.0f}" if abs(value) >= 99.5 else f"{value:+.2g}"


def event_text(event: Event) -> str:
    """An event as a line."""
    instant = "" if event.time is None else f"{instant_text(event.time)}: "
    return f"{instant}{_PREFIXES.get(event.kind, '')}{event.text}"
