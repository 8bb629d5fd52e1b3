"""What the live view says, in words."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

from hydrofdi.cli.monitor.watched import Watched
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import readable
from hydrofdi.monitor.lines import Event, EventKind, WindowLine

_FIRST_DATE = 1e9
"""Clocks of streams beyond it count from 1970 [s]; those below start when the machine does."""

_COUNTED = {
    EventKind.GAP: ("gap", "gaps"),
    EventKind.DUPLICATE: ("duplicate", "duplicates"),
    EventKind.TIME_RAN_BACK: ("sample back in time", "samples back in time"),
    EventKind.MALFORMED: ("malformed", "malformed"),
    EventKind.DROPPED: ("dropped", "dropped"),
    EventKind.DISCONNECTED: ("disconnection", "disconnections"),
}
"""Events that are counted on the screen, with their names for one and for several."""


def instant_text(time: float) -> str:
    """An instant on the clock of a stream [s]: local time where it counts from 1970."""
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
    """What stands beside the condition: since when, or why nothing is known."""
    if watched.is_silent:
        return _silence_text(watched)
    if watched.since is None or watched.time is None:
        return "no window was judged yet"
    return f"since {instant_text(watched.since)} ({duration_text(max(watched.time - watched.since, 0.0))})"


def _silence_text(watched: Watched) -> str:
    silence = duration_text(round(watched.silence, 1))
    connection = "disconnected, " if watched.is_connected is False else ""
    if watched.last_data is None:
        return f"{connection}waiting for samples for {silence}"
    return f"{connection}no samples for {silence}; last condition: {watched.condition}"


def flow_text(watched: Watched) -> str:
    """Samples in a second, how late they are, and how long the view is open."""
    parts = [f"{watched.rate:,.0f} samples/s"]
    if watched.lag is not None:
        parts.append(f"lag {duration_text(watched.lag)}")
    return ", ".join(parts)


def reading_text(watched: Watched) -> str:
    """The last window: score, margin, what the chart says, or why it is not judged."""
    if not watched.windows:
        return f"{score_name(watched.file)}: {limits_text(watched.file)}"
    line, file = watched.windows[-1], watched.file
    verdict = line.verdict
    score = "no score" if verdict.score is None else readable(verdict.score, file.unit)
    if verdict.fault is not None:
        return f"{score_name(file)} {score}; not judged, {verdict.fault.kind}: {verdict.fault.text}"
    margin = "" if verdict.margin is None else f", margin {signed(verdict.margin)} spreads"
    return f"{score_name(file)} {score}; {limits_text(file)}{margin}{chart_text(line)}"


def score_name(file: DetectorFile) -> str:
    """The score as ``indicator.output``."""
    return ".".join(part for part in (file.config.indicator, file.config.output) if part)


def limits_text(file: DetectorFile) -> str:
    """The limits of the score."""
    low, high = file.limits.low, file.limits.high
    texts = [f"below {readable(low, file.unit)}"] if low is not None else []
    texts += [f"above {readable(high, file.unit)}"] if high is not None else []
    return f"alarm {' or '.join(texts)}"


def chart_text(line: WindowLine) -> str:
    """What the control chart says."""
    if line.chart is None or line.chart.statistic is None:
        return ""
    return f", chart {line.chart.statistic:.3g} of {line.chart.limit:.3g}"


def signed(value: float) -> str:
    """A number with two digits and a typographic sign."""
    return f"{value:+.2g}".replace("-", "−")


def counts_text(watched: Watched) -> str:
    """How many windows came, what became of them, and what was wrong with the stream."""
    return "; ".join((windows_text(watched), *_faults(watched), *_events(watched)))


def windows_text(watched: Watched) -> str:
    """How many windows were judged, and how many raised an alarm."""
    return f"{_number(watched.n_judged, 'window')} judged, {_number(watched.n_alarm, 'alarm')}"


def _faults(watched: Watched) -> Iterator[str]:
    if watched.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in watched.faults.most_common())
        yield f"{watched.faults.total():,} not judged ({kinds})"


def _events(watched: Watched) -> Iterator[str]:
    for kind, (one, several) in _COUNTED.items():
        if n := watched.counts[kind]:
            yield f"{n:,} {one if n == 1 else several}"


def _number(n: int, noun: str) -> str:
    return f"{n:,} {noun}{'' if n == 1 else 's'}"


def promise_text(file: DetectorFile) -> str:
    """The promise of the detector, and what it rests on."""
    basis, limits = file.basis, file.limits
    groups = f" of {_number(basis.n_group, 'group')}" if basis.n_group else ""
    rests = f"from {_number(basis.n_window, 'healthy window')}{groups}"
    if file.chart is not None and file.config.chart is not None:
        wanted = duration_text(file.config.chart.false_alarm_every)
        low, high = file.chart.interval
        upper = "no upper end" if high is None else duration_text(high)
        return f"Promise: one false alarm in {wanted} of operation ({duration_text(low)} to {upper}), {rests}"
    low, high = (100.0 * share for share in limits.interval)
    wanted_share = f"{100.0 * limits.false_alarm_rate:.2g} %"
    return f"Promise: {wanted_share} of healthy windows raise an alarm ({low:.2g} to {high:.2g} %), {rests}"


def event_text(event: Event) -> str:
    """An event as a line."""
    return event.text if event.time is None else f"{instant_text(event.time)}  {event.text}"


def summary_text(watched: Watched, seconds: float) -> str:
    """What is left on the terminal when the view is closed."""
    last = str(watched.condition)
    if watched.since is not None:
        last += f" since {instant_text(watched.since)}"
    return f"{watched.source}, watched for {duration_text(seconds)}: {counts_text(watched)}; at the end: {last}"
