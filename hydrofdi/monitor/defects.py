"""Defects of samples: reported once, then counted."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.records.streams import Chunk, Finding, State

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
