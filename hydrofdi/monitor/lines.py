"""Lines of a monitor: one for each window, and one for each event."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from hydrofdi.detectors.trained import ChartReading, Verdict


class Condition(StrEnum):
    """The condition of the actuator, as the monitor judges it."""

    UNKNOWN = "unknown"
    """No window was judged yet, or none recently."""
    HEALTHY = "healthy"
    ALARM = "alarm"


class EventKind(StrEnum):
    """Kinds of events."""

    STARTED = "started"
    RESUMED = "resumed"
    STOPPED = "stopped"
    ALARM_RAISED = "alarm_raised"
    ALARM_CLEARED = "alarm_cleared"
    GAP = "gap"
    DUPLICATE = "duplicate"
    TIME_RAN_BACK = "time_ran_back"
    RATE_CHANGED = "rate_changed"
    MISSING_SAMPLES = "missing_samples"
    STUCK = "stuck"
    CLIPPED = "clipped"
    NOVEL = "novel"
    MISSING_CHANNEL = "missing_channel"
    NOT_JUDGED = "not_judged"
    MALFORMED = "malformed"
    DROPPED = "dropped"
    NOTICE = "notice"
    CONNECTED = "connected"
    DISCONNECTED = "disconnected"
    NOT_STORED = "not_stored"
    INSECURE = "insecure"


@dataclass(frozen=True)
class Event:
    """Something that happened to the stream, the source or the machine.

    Attributes
    ----------
    kind : EventKind
    text : str
        The event in words.
    time : float or None
        Instant on the clock of the stream [s].
    count : int
        Number of occurrences. What continues is reported once when it begins. The counts of one kind,
        without lines that end an episode, add up to all occurrences.
    is_silent : bool
        Whether it is only counted, because it was reported before.
    is_end : bool
        Whether it ends an episode; `count` is then the count of the whole episode.
    """

    kind: EventKind
    text: str
    time: float | None = None
    count: int = 1
    is_silent: bool = False
    is_end: bool = False


@dataclass(frozen=True)
class WindowLine:
    """A window and its verdict.

    Attributes
    ----------
    number : int
        From 0; it continues over gaps and restarts, so that repeated lines can be recognised.
    start, end : float
        Instants of the first and last sample [s].
    verdict : Verdict
    chart : ChartReading or None
    condition : Condition
        Condition after this window.
    """

    number: int
    start: float
    end: float
    verdict: Verdict
    chart: ChartReading | None
    condition: Condition


Line = WindowLine | Event
