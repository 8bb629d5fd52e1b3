"""Episodes of windows that cannot be judged; their start and their end are reported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained import Verdict
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.records import Array
from hydrofdi.records.streams import State

_KIND_OF_FAULT = {
    "other_rate": EventKind.RATE_CHANGED,
    "missing": EventKind.MISSING_SAMPLES,
    "stuck": EventKind.STUCK,
    "clipped": EventKind.CLIPPED,
    "novel": EventKind.NOVEL,
    "missing_channel": EventKind.MISSING_CHANNEL,
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
