"""The summary that remains on the terminal when the view is closed."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.cli.monitor.live.counting import event_texts, fault_texts, n_alarm, windows_text
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.cli.monitor.live.wording import duration_text, instant_text

_MOST_ALARMS = 10
"""Most alarms whose instants are listed."""


def summary_lines(watched: Watched) -> Iterator[str]:
    """The condition at the end, and the counts: windows, alarms with instants, faults, events."""
    condition = str(watched.condition)
    if watched.since is not None:
        condition += f" since {instant_text(watched.since)}"
    yield f"{watched.source}, watched for {duration_text(watched.arrivals.age)}; at the end: {condition}"
    yield windows_text(watched)
    if watched.alarms:
        yield f"alarms raised at {_alarms(watched)}"
    yield from fault_texts(watched)
    if events := ", ".join(event_texts(watched)):
        yield events


def _alarms(watched: Watched) -> str:
    told = list(watched.alarms)[-_MOST_ALARMS:]
    before = n_alarm(watched) - len(told)
    instants = ", ".join(map(instant_text, told))
    return f"{instants}; {before:,} before" if before else instants
