"""Values of several nodes, each with a time stamp of its own, joined to samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrofdi.records.batch import Array


class NodeValue(NamedTuple):
    """A value of one node: instant [s], position of its channel, value in its unit, when it arrived [s]."""

    time: float
    channel: int
    value: float
    arrival: float


@dataclass
class _Instant:
    time: float
    values: dict[int, NodeValue]


class Joiner:
    """Joins values whose time stamps lie within half a sampling period.

    If a node has no value for an instant, the sample is NaN. The instant is complete without it as soon as
    the node has sent a later value, or after `wait` seconds. Before the first instant with all nodes, up to
    `wait` seconds of other instants are dropped, because nodes do not begin together.

    Parameters
    ----------
    n_channel : int
    period : float
        Sampling period [s].
    wait : float
        [s]
    """

    def __init__(self, n_channel: int, period: float, wait: float) -> None:
        self._n_channel, self._tolerance, self._wait = n_channel, period / 2, wait
        self._patience = round(wait / period)
        self._last = -np.inf
        self.begin()

    def begin(self) -> None:
        """Begin a new connection; pending values of the old one are dropped."""
        self._pending: list[NodeValue] = []
        self._latest = [-np.inf] * self._n_channel
        self._left_out = 0

    def add(self, values: Sequence[NodeValue], now: float) -> tuple[Array, Array]:
        """Add values, those of a node in the order in which it sent them, and return the ready samples.

        Parameters
        ----------
        values : sequence of NodeValue
        now : float
            Present instant on the clock of `arrival` [s].

        Returns
        -------
        time : ndarray, shape (n_time,)
            Instants that have all nodes, or have waited long enough [s].
        samples : ndarray, shape (n_time, n_channel)
            In the units of the nodes; NaN if a node has no value.
        """
        for value in values:
            self._latest[value.channel] = value.time
        self._pending = sorted((*self._pending, *values))
        instants = self._instants()
        n_ready = 0
        while n_ready < len(instants) and self._is_ready(instants[n_ready], now):
            n_ready += 1
        self._pending = [value for instant in instants[n_ready:] for value in instant.values.values()]
        kept = [instant for instant in instants[:n_ready] if self._is_kept(instant)]
        samples = np.full((len(kept), self._n_channel), np.nan)
        for row, instant in enumerate(kept):
            for value in instant.values.values():
                samples[row, value.channel] = value.value
        return np.array([instant.time for instant in kept]), samples

    def _instants(self) -> list[_Instant]:
        instants: list[_Instant] = []
        for value in self._pending:
            here = instants[-1] if instants else None
            if here is None or value.time - here.time > self._tolerance or _differs(here, value):
                here = _Instant(value.time, {})
                instants.append(here)
            here.values[value.channel] = value
        return instants

    def _is_whole(self, instant: _Instant) -> bool:
        return len(instant.values) == self._n_channel

    def _is_ready(self, instant: _Instant, now: float) -> bool:
        missing = set(range(self._n_channel)) - instant.values.keys()
        if all(self._latest[channel] - instant.time > self._tolerance for channel in missing):
            return True
        return now - min(value.arrival for value in instant.values.values()) > self._wait

    def _is_kept(self, instant: _Instant) -> bool:
        if self._is_whole(instant):
            self._left_out = self._patience
        elif instant.time <= self._last + self._tolerance:
            return False
        elif self._left_out < self._patience:
            self._left_out += 1
            return False
        self._last = instant.time
        return True


def _differs(instant: _Instant, value: NodeValue) -> bool:
    """Whether the instant has another value of the node, from another time."""
    other = instant.values.get(value.channel)
    return other is not None and other.time != value.time
