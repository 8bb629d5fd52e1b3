"""Texts of the live view: its counts, and the promise of the detector."""

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
    EventKind.TIME_RAN_BACK: ("out-of-order sample", "out-of-order samples"),
    EventKind.MALFORMED: ("malformed", "malformed"),
    EventKind.DROPPED: ("dropped", "dropped"),
    EventKind.DISCONNECTED: ("disconnection", "disconnections"),
}
"""Kind of event that the screen counts → singular and plural of its name."""


def counts_text(watched: Watched) -> str:
    """The numbers of windows, of faults and of defects of the stream."""
    return "; ".join((windows_text(watched), *fault_texts(watched), *event_texts(watched)))


def windows_text(watched: Watched) -> str:
    """The numbers of judged windows, of windows beyond the limit, and of raised alarms."""
    judged = f"{counted(watched.n_judged, judged_noun(watched.file))} judged"
    return f"{judged}, {watched.n_beyond:,} beyond the limit, {counted(n_alarm(watched), 'alarm')}"


def n_alarm(watched: Watched) -> int:
    """Number of raised alarms."""
    return watched.counts[EventKind.ALARM_RAISED]


def fault_texts(watched: Watched) -> Iterator[str]:
    """The number of windows that were not judged, by kind of fault."""
    if watched.faults:
        kinds = ", ".join(f"{kind} {n:,}" for kind, n in watched.faults.most_common())
        yield f"{watched.faults.total():,} not judged ({kinds})"


def event_texts(watched: Watched) -> Iterator[str]:
    """The numbers of defects of the stream, by kind."""
    for kind, (one, several) in _COUNTED.items():
        if n := watched.counts[kind]:
            yield f"{n:,} {one if n == 1 else several}"


def promise_text(file: DetectorFile) -> str:
    """The promise of the detector, and the records behind it."""
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
