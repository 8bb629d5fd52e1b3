"""Samples of a stream that come one sensor at a time: those of one instant are joined."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk, State

_WAIT, _MOST = 2.0, 4096
"""How long [s], and with how many later ones, a sample waits for a channel that sends nothing more."""
_stamp = itemgetter(0)


class Joining:
    """Joins samples within half a sampling period that have different channels; others stay as they are.

    A sample without a channel is complete as soon as this channel has a later value. The results do not
    depend on the chunks.
    """

    def __init__(self, sampling_frequency: float, channels: Sequence[Channel]) -> None:
        self._channels, self._tolerance = tuple(channels), 0.501 / sampling_frequency

    def start(self) -> State:
        """The state before the first sample: samples that wait, and the latest instant of each channel."""
        return {
            "rows": np.empty((0, 1 + len(self._channels))),
            "latest": np.full(len(self._channels), -np.inf),
        }

    def step(self, state: State, chunk: Chunk, *, is_end: bool = False) -> tuple[State, Chunk]:
        """The state after a chunk, and the samples that are complete, at the end of a stream all of them."""
        missing = np.full(chunk.n_time, np.nan)
        samples = [chunk.channels.get(channel, missing) for channel in self._channels]
        rows = np.column_stack([chunk.time, *samples])
        if not state["rows"].size and not np.isnan(rows).any():
            if not chunk.n_time:
                return state, chunk
            return {**state, "latest": np.full(len(samples), chunk.time[-1])}, chunk
        waiting, latest = state["rows"].tolist(), state["latest"].tolist()
        ready, unread = list[list[float]](), dict[int, str]()
        for place, row in enumerate(rows.tolist()):
            if not math.isfinite(row[0]):
                unread |= {len(ready): chunk.unread[place]} if place in chunk.unread else {}
                ready.append(row)
                continue
            present = [n for n, value in enumerate(row[1:], 1) if not math.isnan(value)]
            for n in present:
                latest[n - 1] = row[0]
            if (fitting := self._fitting(waiting, row[0], present)) is not None:
                for n in present:
                    fitting[n] = row[n]
            else:
                insort(waiting, row, key=_stamp)
            n_ready = 0
            while n_ready < len(waiting) and self._is_ready(waiting, n_ready, latest):
                n_ready += 1
            ready += waiting[:n_ready]
            del waiting[:n_ready]
        if is_end:
            ready, waiting = ready + waiting, []
        time, *columns = np.array(ready).reshape(-1, rows.shape[1]).T.copy()
        held = np.array(waiting).reshape(-1, rows.shape[1])
        found = Chunk(time, dict(zip(self._channels, columns, strict=True)), unread)
        return {"rows": held, "latest": np.array(latest)}, found

    def _fitting(self, waiting: Sequence[list[float]], time: float, present: list[int]) -> list[float] | None:
        """The nearest of the waiting samples that lacks the channels of another one."""
        place, found = bisect_left(waiting, time - self._tolerance, key=_stamp), list[list[float]]()
        while place < len(waiting) and waiting[place][0] <= time + self._tolerance:
            found += [waiting[place]] if all(math.isnan(waiting[place][n]) for n in present) else []
            place += 1
        return min(found, key=lambda other: abs(other[0] - time), default=None)

    def _is_ready(self, waiting: Sequence[list[float]], place: int, latest: Sequence[float]) -> bool:
        time, *values = waiting[place]
        if waiting[-1][0] - time > _WAIT or len(waiting) - place > _MOST:
            return True
        return all(
            not math.isnan(value) or newest > time + self._tolerance
            for value, newest in zip(values, latest, strict=True)
        )
