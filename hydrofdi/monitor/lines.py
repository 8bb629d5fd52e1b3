"""What a monitor says: a line for each window, and one for each event."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from hydrofdi.detectors.trained import ChartReading, Verdict


class Condition(StrEnum):
    """What the monitor takes the actuator for."""

    UNKNOWN = "unknown"
    """No window was judged yet, or not for long."""
    HEALTHY = "healthy"
    ALARM = "alarm"


class EventKind(StrEnum):
    """What happens beside windows."""

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
        The sentence for a person.
    time : float or None
        On the clock of the stream [s].
    count : int
        How often. What continues is said once when it begins. The counts of one kind, those of lines that end
        an episode left out, add up to all there was.
    is_silent : bool
        Whether it is counted alone, because it was said before.
    is_end : bool
        Whether it says that an episode is over; `count` is then that of the whole episode.
    """

    kind: EventKind
    text: str
    time: float | None = None
    count: int = 1
    is_silent: bool = False
    is_end: bool = False


@dataclass(frozen=True)
class WindowLine:
    """A window and what is said of it.

    Attributes
    ----------
    number : int
        From 0; it continues over gaps and restarts, so that a line that comes twice can be told.
    start, end : float
        Instants of the first and last sample [s].
    verdict : Verdict
    chart : ChartReading or None
    condition : Condition
        After this window.
    """

    number: int
    start: float
    end: float
    verdict: Verdict
    chart: ChartReading | None
    condition: Condition


Line = WindowLine | Event
