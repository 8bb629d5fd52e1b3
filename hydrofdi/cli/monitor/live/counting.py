"""What the live view counts, and what the detector promises, in words."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.api.monitoring.lines import EventKind
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.cli.monitor.live.wording import duration_text, judged_noun
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import percent, percentage
from hydrofdi.settings.counting import counted

_COUNTED = {
    EventKind.GAP: ("gap", "gaps"),
    EventKind.DUPLICATE: ("duplicate", "duplicates"),
    EventKind.TIME_RAN_BACK: ("sample back in time", "samples back in time"),
    EventKind.MALFORMED: ("malformed", "malformed"),
    EventKind.DROPPED: ("dropped", "dropped"),
    EventKind.DISCONNECTED: ("disconnection", "disconnections"),
}
"""Events that are counted on the screen, with their names for one and for several."""


def counts_text(watched: Watched) -> str:
    """How many windows came, what became of them, and what was wrong with the stream."""
    return "; ".join((windows_text(watched), *fault_texts(watched), *event_texts(watched)))


def windows_text(watched: Watched) -> str:
    """How many windows were judged, how many lie beyond the limit, and how many alarms were raised."""
    judged = f"{counted(watched.n_judged, judged_noun(watched.file))} judged"
    return f"{judged}, {watched.n_beyond:,} beyond the limit, {counted(n_alarm(watched), 'alarm')}"


def n_alarm(watched: Watched) -> int:
    """Alarms that were raised."""
    return watched.counts[EventKind.ALARM_RAISED]


def fault_texts(watched: Watched) -> Iterator[str]:
    """How many windows were not judged, by kind."""
    if watched.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in watched.faults.most_common())
        yield f"{watched.faults.total():,} not judged ({kinds})"


def event_texts(watched: Watched) -> Iterator[str]:
    """What was wrong with the stream, counted."""
    for kind, (one, several) in _COUNTED.items():
        if n := watched.counts[kind]:
            yield f"{n:,} {one if n == 1 else several}"


def promise_text(file: DetectorFile) -> str:
    """The promise of the detector, and what it rests on."""
    basis, limits = file.basis, file.limits
    groups = f" of {counted(basis.n_group, 'group')}" if basis.n_group else ""
    noun = judged_noun(file)
    rests = f"from {counted(basis.n_window, f'healthy {noun}')}{groups}"
    if file.chart is not None and file.config.chart is not None:
        wanted = duration_text(file.config.chart.false_alarm_every)
        low, high = file.chart.interval
        upper = "no upper end" if high is None else duration_text(high)
        return f"Promise: one false alarm in {wanted} of operation ({duration_text(low)} to {upper}), {rests}"
    low, high = limits.interval
    ends = f"{percentage(low)} to {percent(high)}"
    wanted = percent(limits.false_alarm_rate)
    return f"Promise: {wanted} of healthy {noun}s lie beyond the limit ({ends}), {rests}"
