"""Lines of a stream: one for each window, and one for each event; the same JSON everywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.verdicts import Verdict
from hydrofdi.records import Array
from hydrofdi.records.streams import Chunk, Event, EventKind, State
from hydrofdi.settings.messages import counted, plain


@dataclass(frozen=True)
class ChartReading:
    """Reading of the control chart: statistic and limit [healthy spreads], and whether it alarms."""

    statistic: float | None
    limit: float
    alarm: bool


class Condition(StrEnum):
    """The condition of the actuator, as the monitor judges it."""

    UNKNOWN = "unknown"
    """No window was judged yet, or none recently."""
    HEALTHY = "healthy"
    ALARM = "alarm"


@dataclass(frozen=True)
class WindowLine:
    """A window and its verdict.

    Attributes
    ----------
    number : int
        From 0; it continues over gaps and restarts, so that repeated lines can be recognised.
    start, end : float
        Instants of the first and last sample [s].
    condition : Condition
        Condition after this window.
    record_id, source, group, label : str
        Of the record that it belongs to, where that is known.
    """

    number: int
    start: float
    end: float
    verdict: Verdict
    chart: ChartReading | None = None
    condition: Condition = Condition.UNKNOWN
    record_id: str = ""
    source: str = ""
    group: str = ""
    label: str = ""

    @property
    def alarm(self) -> bool | None:
        """Whether it is an alarm, that of the chart if there is one; None if it is not judged."""
        judged = self.verdict.alarm
        return judged if judged is None or self.chart is None else self.chart.alarm


Line = WindowLine | Event


def line_record(line: Line, unit: str = "1") -> dict[str, Any]:
    """A line as an object for JSON; numbers that are not finite are None."""
    if isinstance(line, Event):
        record = {"line": "event", "event": line.kind.value, "time": _finite(line.time)}
        record |= {"count": line.count, "is_end": line.is_end, "text": line.text}
        return record | ({"details": dict(line.details)} if line.details else {})
    verdict, chart = line.verdict, line.chart
    return {
        "line": "window",
        "number": line.number,
        "start": _finite(line.start),
        "end": _finite(line.end),
        "condition": line.condition.value,
        "score": _finite(verdict.score),
        "unit": unit,
        "alarm": line.alarm,
        "margin": _finite(verdict.margin),
        "beyond_limit": verdict.is_beyond,
        "fault": verdict.fault and {"kind": verdict.fault.kind, "text": verdict.fault.message},
        "doubt": verdict.doubt or None,
        "cause": verdict.cause or None,
        "leak": verdict.leak and verdict.leak.to_dict(),
        "oil_temperature": _finite(verdict.temperature),
        "chart": chart and {
            "statistic": _finite(chart.statistic),
            "limit": _finite(chart.limit),
            "alarm": chart.alarm,
        },
    }  # fmt: skip


def is_said(line: Line) -> bool:
    """Whether a line is more than counted."""
    return not (isinstance(line, Event) and line.is_silent)


def _finite(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else float(number)


MINUTE = 60.0
"""Interval at which continuing defects are summed up [s]."""

_WORDS = {
    EventKind.GAP: "gap",
    EventKind.RATE_CHANGED: "off-rate sample",
    EventKind.DUPLICATE: "duplicate sample",
    EventKind.TIME_RAN_BACK: "out-of-order sample",
    EventKind.MALFORMED: "unreadable sample",
}
_KINDS = list(_WORDS)


_KIND_OF_FAULT = {
    "other_rate": EventKind.RATE_CHANGED,
    "missing": EventKind.MISSING_SAMPLES,
    **{each: EventKind(each) for each in ("stuck", "clipped", "novel", "missing_channel")},
}
_BEYOND = "novel, the score beyond its limit"
_EPISODES = {
    **{kind.value.replace("_", " "): kind for kind in (*_KIND_OF_FAULT.values(), EventKind.NOT_JUDGED)},
    _BEYOND: EventKind.NOVEL,
}
"""Name of an episode → kind of its events; a score beyond its limit makes an episode of its own."""

_NAMES = list(_EPISODES)


NO_EPISODES: State = {
    "count": np.zeros(len(_NAMES), dtype=np.int64),
    "quiet": np.zeros(len(_NAMES), dtype=np.int64),
    "span": np.full((len(_NAMES), 2), np.nan),
}


NO_DEFECTS: State = {"waiting": np.zeros(len(_KINDS), dtype=np.int64), "minute": np.array(-np.inf)}

NOT_KNOWN: State = {
    **{name: np.array(0) for name in ("is_raised", "n_calm", "n_not_judged")},
    "since": np.array(np.nan),
    **{name: np.array(0) for name in ("n_judged", "n_alarm")},
}


def noted(state: State, pieces: Sequence[Chunk], findings: Sequence[Event]) -> tuple[State, list[Event]]:
    """Defects after findings: the first of an episode is an event, the others wait for a minute to end."""
    events = list[Event]()
    if begins_minute(state, pieces):
        state, events = summed_up(state)
    waiting = state["waiting"].copy()
    for event in findings:
        waiting[_KINDS.index(event.kind)] += event.count - (not event.is_silent)
        events += [] if event.is_silent else [replace(event, count=1)]
    minute = np.array(pieces[-1].time[-1] // MINUTE) if pieces else state["minute"]
    return {"waiting": waiting, "minute": minute}, events


def begins_minute(state: State, pieces: Sequence[Chunk]) -> bool:
    """Whether pieces have a sample in another minute than the last sample before."""
    ends = (time for piece in pieces for time in (piece.time[0], piece.time[-1]))
    return any(time // MINUTE != state["minute"] for time in ends)


def summed_up(state: State) -> tuple[State, list[Event]]:
    """Defects after a minute of the stream's clock, and an event for each kind that was only counted."""
    minute = float(state["minute"])
    end = MINUTE * (minute + 1.0) if math.isfinite(minute) else None
    until = "" if end is None else f" up to {end:.10g} s"
    events = [
        Event(kind, f"{counted(int(count), f'more {_WORDS[kind]}')}{until}", end, int(count))
        for kind, count in zip(_KINDS, state["waiting"], strict=True)
        if count
    ]
    return {**state, "waiting": np.zeros_like(state["waiting"])}, events


def conditioned(state: State, patience: int, window: WindowLine) -> tuple[State, Condition, Event | None]:
    """The state after a window, the condition, and the event if an alarm is raised or cleared.

    An alarm is raised at the first alarm of the chart, or of the threshold if there is no chart, and cleared
    after `patience` judged windows in a row without one. After as many windows that are not judged, the
    condition is unknown.
    """
    is_alarm, is_raised, event = window.alarm, bool(state["is_raised"]), None
    n_not_judged = min(int(state["n_not_judged"]) + 1, patience) if is_alarm is None else 0
    state = {**state, "n_not_judged": np.array(n_not_judged)}
    if is_alarm is not None:
        n_calm = 0 if is_alarm else min(int(state["n_calm"]) + 1, patience)
        state["n_calm"] = np.array(n_calm)
        state |= {"n_judged": state["n_judged"] + 1, "n_alarm": state["n_alarm"] + is_alarm}
        if is_alarm and not is_raised:
            state |= {"is_raised": np.array(1), "since": np.array(window.end)}
            event = Event(EventKind.ALARM_RAISED, _why(window), window.end)
        elif is_raised and n_calm >= patience:
            since = f"{float(state['since']):.10g} s"
            text = f"no alarm in {counted(n_calm, 'window')}; the alarm was raised at {since}"
            state["is_raised"] = np.array(0)
            event = Event(EventKind.ALARM_CLEARED, text, window.end)
    known = Condition.ALARM if state["is_raised"] else Condition.HEALTHY
    return state, Condition.UNKNOWN if n_not_judged >= patience else known, event


def _why(window: WindowLine) -> str:
    verdict, chart = window.verdict, window.chart
    doubt = f" by {verdict.cause}" if verdict.cause else ""
    doubt += f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
    if chart is not None:
        statistic, limit = (plain(each, 4) for each in (chart.statistic or 0.0, chart.limit))
        return f"the statistic of the chart, {statistic}, reaches its limit, {limit}{doubt}"
    return f"the score is {plain(-(verdict.margin or 0.0), 4)} healthy spreads beyond its limit{doubt}"


def episodes_after(state: State, patience: int, window: WindowLine) -> tuple[State, list[Event]]:
    """Faults of windows after another one, and events: an episode of a kind of fault ends after `patience`
    windows without it."""
    start, end, verdict = window.start, window.end, window.verdict
    if verdict.fault is None and not state["count"].any():
        return state, []
    count, span = state["count"].copy(), state["span"].copy()
    quiet = np.where(count > 0, state["quiet"] + 1, 0)
    events = []
    if verdict.fault is not None:
        kind = _KIND_OF_FAULT.get(verdict.fault.kind, EventKind.NOT_JUDGED)
        row = _NAMES.index(_BEYOND if verdict.is_beyond else kind.value.replace("_", " "))
        is_going_on = bool(count[row])
        span[row] = (span[row, 0] if is_going_on else start), end
        count[row], quiet[row] = count[row] + 1, 0
        text = f"from {start:.10g} s on, windows are not judged: {verdict.fault.message}"
        events.append(Event(kind, text, start, is_silent=is_going_on))
    for row in np.flatnonzero(quiet >= patience).tolist():
        events.append(_over(row, count, span))
        count[row], quiet[row] = 0, 0
    return {"count": count, "quiet": quiet, "span": span}, events


def _over(row: int, count: NDArray[np.int64], span: Array) -> Event:
    name, n, (start, end) = _NAMES[row], int(count[row]), span[row]
    text = f"over: {n} window{'s' * (n > 1)} not judged ({name}) from {start:.10g} s to {end:.10g} s"
    return Event(_EPISODES[name], text, float(end), n, is_end=True)


def ended(state: State) -> list[Event]:
    """The ends of all episodes."""
    count = state["count"]
    return [_over(row, count, state["span"]) for row in np.flatnonzero(count).tolist()]
