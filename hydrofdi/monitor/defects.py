"""What is wrong with samples, said once and counted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.records.streams import Chunk, Finding, State

MINUTE = 60.0
"""What goes on is summed up as often [s]."""

_WORDS = {
    EventKind.GAP: "gaps",
    EventKind.RATE_CHANGED: "samples at another rate",
    EventKind.DUPLICATE: "samples that came twice",
    EventKind.TIME_RAN_BACK: "samples that came too late",
    EventKind.MALFORMED: "samples without a finite time stamp",
}
_KINDS = list(_WORDS)


class Defects:
    """Findings go in; events come out: the first of an episode, then a line a minute with the count.

    Minutes are those of the stream, so that events do not depend on the chunks.
    """

    def start(self) -> State:
        """The state before the first sample."""
        return {"waiting": np.zeros(len(_KINDS), dtype=np.int64), "latest": np.array(-np.inf)}

    def has_waiting(self, state: State) -> bool:
        """Whether there is something to sum up when the minute is over."""
        return bool(state["waiting"].any())

    def step(self, state: State, findings: Sequence[Finding]) -> tuple[State, list[Event]]:
        """The state behind findings, and those that are news."""
        waiting = state["waiting"].copy()
        events = []
        for finding in findings:
            kind = EventKind(finding.kind)
            waiting[_KINDS.index(kind)] += finding.count - finding.is_news
            if finding.is_news:
                events.append(Event(kind, finding.text, finding.time))
        return {**state, "waiting": waiting}, events

    def minutes(self, state: State, chunk: Chunk) -> Iterator[tuple[bool, Chunk]]:
        """Parts of a chunk, and whether a new minute begins with them."""
        minute = _minutes(state["latest"], chunk)
        begins = minute[1:] > minute[:-1]
        cuts = np.unique([0, *np.flatnonzero(begins), chunk.n_time]).tolist()
        for first, stop in pairwise(cuts):
            yield bool(begins[first]), part(chunk, first, stop)

    def passed(self, state: State, chunk: Chunk) -> State:
        """The state behind a chunk."""
        return {**state, "latest": _latest(state["latest"], chunk)[-1]}

    def sum_up(self, state: State) -> tuple[State, list[Event]]:
        """What a minute brought that was not said."""
        latest = float(state["latest"])
        end = MINUTE * (math.floor(latest / MINUTE) + 1) if math.isfinite(latest) else None
        until = "" if end is None else f" up to {end:.10g} s"
        events = [
            Event(kind, f"{count} more {_WORDS[kind]}{until}", end, int(count))
            for kind, count in zip(_KINDS, state["waiting"], strict=True)
            if count
        ]
        return {**state, "waiting": np.zeros_like(state["waiting"])}, events


def part(chunk: Chunk, first: int, stop: int) -> Chunk:
    """Some of the samples of a chunk."""
    return Chunk(chunk.time[first:stop], {name: row[first:stop] for name, row in chunk.channels.items()})


def _latest(before: NDArray[np.float64], chunk: Chunk) -> NDArray[np.float64]:
    """The latest finite instant before the chunk, and behind each of its samples (1 + n_time,)."""
    stamps = np.where(np.isfinite(chunk.time), chunk.time, -np.inf)
    return np.maximum.accumulate(np.concatenate([np.atleast_1d(before), stamps]))


def _minutes(before: NDArray[np.float64], chunk: Chunk) -> NDArray[np.float64]:
    return np.floor(_latest(before, chunk) / MINUTE)
