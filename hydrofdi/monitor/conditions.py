"""Defects of samples and verdicts → events, episodes, and the condition of the actuator."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.following import ChartReading
from hydrofdi.detectors.trained.measuring import Verdict
from hydrofdi.monitor.lines import Condition, Event, EventKind
from hydrofdi.records import Array
from hydrofdi.records.streams import Chunk, Finding, State
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import plain

MINUTE = 60.0
"""Interval at which continuing defects are summed up [s]."""

_WORDS = {
    EventKind.GAP: "gaps",
    EventKind.RATE_CHANGED: "samples at another rate",
    EventKind.DUPLICATE: "duplicate samples",
    EventKind.TIME_RAN_BACK: "out-of-order samples",
    EventKind.MALFORMED: "samples that could not be read or have no time stamp",
}
_KINDS = list(_WORDS)


class Defects:
    """Turns findings into events: the first of an episode, then a line per minute with the count.

    Minutes are those of the stream's clock, so that events do not depend on the chunks.
    """

    def start(self) -> State:
        """The state before the first sample."""
        return {"waiting": np.zeros(len(_KINDS), dtype=np.int64), "minute": np.array(-np.inf)}

    def has_waiting(self, state: State) -> bool:
        """Whether there is something to sum up when the minute is over."""
        return bool(state["waiting"].any())

    def step(self, state: State, findings: Sequence[Finding]) -> tuple[State, list[Event]]:
        """The state after findings, and events of those that are news."""
        waiting = state["waiting"].copy()
        events = []
        for finding in findings:
            kind = EventKind(finding.kind)
            waiting[_KINDS.index(kind)] += finding.count - finding.is_news
            if finding.is_news:
                events.append(Event(kind, finding.text, finding.time))
        return {**state, "waiting": waiting}, events

    def begins_minute(self, state: State, pieces: Sequence[Chunk]) -> bool:
        """Whether pieces have a sample in another minute than the last sample before."""
        ends = (float(time) for piece in pieces for time in (piece.time[0], piece.time[-1]))
        return any(_minute(time) != state["minute"] for time in ends)

    def passed(self, state: State, pieces: Sequence[Chunk]) -> State:
        """The state after pieces."""
        return {**state, "minute": np.array(_minute(pieces[-1].time[-1]))} if pieces else state

    def sum_up(self, state: State) -> tuple[State, list[Event]]:
        """The state after a minute, and an event for each kind of defect that was only counted."""
        minute = float(state["minute"])
        end = MINUTE * (minute + 1.0) if math.isfinite(minute) else None
        until = "" if end is None else f" up to {end:.10g} s"
        events = [
            Event(kind, f"{count} more {_WORDS[kind]}{until}", end, int(count))
            for kind, count in zip(_KINDS, state["waiting"], strict=True)
            if count
        ]
        return {**state, "waiting": np.zeros_like(state["waiting"])}, events


def _minute(time: float) -> float:
    return float(time // MINUTE)


class Conditions:
    """Raises an alarm at the first alarm of the chart, or of the threshold if there is no chart. Clears it
    after `patience` judged windows in a row without an alarm. After as many windows that are not judged, the
    condition is unknown.

    Parameters
    ----------
    patience : int
        Number of windows.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience

    def start(self) -> State:
        """The state before the first window: the condition is unknown."""
        counts = {"is_raised": 0, "n_calm": 0, "n_not_judged": self._patience}
        return {"since": np.array(np.nan), **{name: np.array(count) for name, count in counts.items()}}

    def step(
        self, state: State, end: float, verdict: Verdict, chart: ChartReading | None
    ) -> tuple[State, Condition, list[Event]]:
        """The state after a window that ends at an instant [s], the condition, and the events."""
        if verdict.alarm is None:
            n_not_judged = min(int(state["n_not_judged"]) + 1, self._patience)
            state = {**state, "n_not_judged": np.array(n_not_judged)}
            return state, self._condition(state), []
        state = {**state, "n_not_judged": np.array(0)}
        is_alarm, is_raised = verdict.alarm if chart is None else chart.alarm, bool(state["is_raised"])
        n_calm = 0 if is_alarm else min(int(state["n_calm"]) + 1, self._patience)
        state = {**state, "n_calm": np.array(n_calm)}
        events: list[Event] = []
        if is_alarm and not is_raised:
            state = {**state, "is_raised": np.array(1), "since": np.array(end)}
            doubt = f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
            events = [Event(EventKind.ALARM_RAISED, _why(verdict, chart) + doubt, end)]
        elif is_raised and n_calm >= self._patience:
            since = f"{float(state['since']):.10g} s"
            text = f"no alarm in {counted(n_calm, 'window')}; the alarm was raised at {since}"
            state = {**state, "is_raised": np.array(0)}
            events = [Event(EventKind.ALARM_CLEARED, text, end)]
        return state, self._condition(state), events

    def _condition(self, state: State) -> Condition:
        if state["n_not_judged"] >= self._patience:
            return Condition.UNKNOWN
        return Condition.ALARM if state["is_raised"] else Condition.HEALTHY


def _why(verdict: Verdict, chart: ChartReading | None) -> str:
    if chart is not None:
        statistic, limit = (plain(each, 4) for each in (chart.statistic or 0.0, chart.limit))
        return f"the statistic of the chart, {statistic}, reaches its limit, {limit}"
    return f"the score is {plain(-(verdict.margin or 0.0), 4)} healthy spreads beyond its limit"


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


class Episodes:
    """Turns faults of windows into events, separately for each kind of fault.

    Parameters
    ----------
    patience : int
        Number of windows without a kind of fault after which its episode is over.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience

    def start(self) -> State:
        """The state before the first window."""
        none = np.zeros(len(_NAMES), dtype=np.int64)
        return {"count": none, "quiet": none, "span": np.full((len(_NAMES), 2), np.nan)}

    def step(self, state: State, start: float, end: float, verdict: Verdict) -> tuple[State, list[Event]]:
        """The state after a window from `start` to `end` [s], and the events."""
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
        for row in np.flatnonzero(quiet >= self._patience).tolist():
            events.append(_over(row, count, span))
            count[row], quiet[row] = 0, 0
        return {"count": count, "quiet": quiet, "span": span}, events

    def end(self, state: State) -> tuple[State, list[Event]]:
        """End the continuing episodes at the end of a stream."""
        rows = np.flatnonzero(state["count"]).tolist()
        return self.start(), [_over(row, state["count"], state["span"]) for row in rows]


def _over(row: int, count: NDArray[np.int64], span: Array) -> Event:
    name, n, (start, end) = _NAMES[row], int(count[row]), span[row]
    text = f"over: {n} window{'s' * (n > 1)} not judged ({name}) from {start:.10g} s to {end:.10g} s"
    return Event(_EPISODES[name], text, float(end), n, is_end=True)
