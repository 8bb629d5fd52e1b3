"""Which samples of a stream are later than those before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array

Mask = NDArray[np.bool_]

FARTHEST = 1e11
"""Largest distance of a time stamp from zero [s]: about 3,000 years."""


@dataclass(frozen=True)
class Order:
    """Samples of a chunk compared with the clock of the stream.

    Attributes
    ----------
    stamps : ndarray, shape (n_time,)
        Instants [s]; −∞ without a time stamp, or beyond `FARTHEST`.
    before : ndarray, shape (n_time,)
        Instant of the last accepted sample before each [s]; −∞ if there was none.
    is_accepted : ndarray of bool, shape (n_time,)
    is_earlier : ndarray of bool, shape (n_time,)
        Samples that were dropped because they are earlier than the last accepted one.
    is_set_back : ndarray of bool, shape (n_time,)
        Samples that were accepted although they are earlier: the clock was set back.
    n_earlier : int
        Number of earlier samples since the last accepted one.
    """

    stamps: Array
    before: Array
    is_accepted: Mask
    is_earlier: Mask
    is_set_back: Mask
    n_earlier: int

    @property
    def last(self) -> float:
        """Instant of the last accepted sample [s]; −∞ before the first."""
        return float((self.stamps if self.is_accepted[-1] else self.before)[-1])


def put_in_order(time: Array, last: float, n_earlier: int, patience: int, comes_again: bool) -> Order:
    """Which samples are later than those before, and where the clock was set back.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        Instants; at least one [s].
    last : float
        Instant of the last accepted sample before the chunk [s].
    n_earlier : int
        Number of earlier samples since.
    patience : int
        Number of samples in a row, all of them earlier, after which the clock was set back.
    comes_again : bool
        Whether the stream is sent again: earlier samples before the first later one then do not count.
    """
    stamps = np.where(np.abs(time) <= FARTHEST, time, -np.inf)
    before = np.empty_like(stamps)
    is_set_back = np.zeros(stamps.size, dtype=bool)
    first = 0
    while first < stamps.size:
        latest = np.maximum.accumulate(np.concatenate([[last], stamps[first:]]))
        before[first:] = latest[:-1]
        counts = _counts(stamps[first:], before[first:], n_earlier, comes_again)
        n_earlier = int(counts[-1])
        over = np.flatnonzero(counts >= patience)
        if not over.size:
            break
        place = first + int(over[0])
        is_set_back[place] = True
        first, last, n_earlier, comes_again = place + 1, float(stamps[place]), 0, False
    is_earlier = np.isfinite(stamps) & (stamps < before) & ~is_set_back
    return Order(stamps, before, (stamps > before) | is_set_back, is_earlier, is_set_back, n_earlier)


def _counts(stamps: Array, before: Array, n_earlier: int, comes_again: bool) -> NDArray[np.intp]:
    """Number of earlier samples since the last accepted one, after each sample."""
    is_earlier = np.isfinite(stamps) & (stamps < before)
    is_later = stamps > before
    if comes_again:
        is_earlier &= np.logical_or.accumulate(is_later)
    counts = n_earlier + np.cumsum(is_earlier)
    since: NDArray[np.intp] = counts - np.maximum.accumulate(np.where(is_later, counts, 0))
    return since
