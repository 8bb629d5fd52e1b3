"""What the live view counts, and what the detector promises, in words."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.cli.monitor.live.wording import duration_text, instant_text, judged_noun
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.detectors.trained.wording import percent, percentage
from hydrofdi.monitor.lines import EventKind

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
    return "; ".join((windows_text(watched), *_faults(watched), *_events(watched)))


def windows_text(watched: Watched) -> str:
    """How many windows were judged, and how many raised an alarm."""
    return (
        f"{_number(watched.n_judged, judged_noun(watched.file))} judged, {_number(watched.n_alarm, 'alarm')}"
    )


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
    noun = judged_noun(file)
    rests = f"from {_number(basis.n_window, f'healthy {noun}')}{groups}"
    if file.chart is not None and file.config.chart is not None:
        wanted = duration_text(file.config.chart.false_alarm_every)
        low, high = file.chart.interval
        upper = "no upper end" if high is None else duration_text(high)
        return f"Promise: one false alarm in {wanted} of operation ({duration_text(low)} to {upper}), {rests}"
    low, high = limits.interval
    ends = f"{percentage(low)} to {percent(high)}"
    wanted = percent(limits.false_alarm_rate)
    return f"Promise: {wanted} of healthy {noun}s raise an alarm ({ends}), {rests}"


def summary_text(watched: Watched) -> str:
    """What is left on the terminal when the view is closed."""
    last = str(watched.condition)
    if watched.since is not None:
        last += f" since {instant_text(watched.since)}"
    lasted = duration_text(watched.arrivals.age)
    return f"{watched.source}, watched for {lasted}: {counts_text(watched)}; at the end: {last}"
