"""Instants at which the drive of an actuator steps, and windows of signals after them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Steps:
    """Steps of the drive in a batch of records, sorted by record and time.

    Attributes
    ----------
    record : ndarray of int, shape (n_step,)
        Row of the record.
    sample : ndarray of int, shape (n_step,)
        First sample after the step.
    """

    record: Places
    sample: Places

    def where(self, chosen: NDArray[np.bool_]) -> Steps:
        """Subset of the steps."""
        return Steps(self.record[chosen], self.sample[chosen])

    def with_window(self, first: int, length: int, n_time: int) -> Steps:
        """Steps whose window ends before the next step and before the end of the record.

        The window has `length` samples and starts `first` samples after the step.
        """
        is_last = np.append(np.diff(self.record) != 0, True)[: self.record.size]
        stop = np.where(is_last, n_time, np.append(self.sample[1:], n_time)[: self.sample.size])
        return self.where(self.sample + first + length <= stop)

    def windows(self, signal: Array, first: int, length: int) -> Array:
        """Samples of a signal (n_record, n_time) in the window after each step, shape (n_step, length)."""
        starts = self.sample + first
        windows: Array = signal[self.record[:, None], starts[:, None] + np.arange(length)]
        return windows

    def sums(self, values: Array, n_record: int) -> Array:
        """Sum of values (n_step,) over the steps of each record, shape (n_record,)."""
        return np.bincount(self.record, values, n_record).astype(np.float64)

    def counts(self, n_record: int) -> Places:
        """Number of steps of each record, shape (n_record,)."""
        counts: Places = np.bincount(self.record, minlength=n_record)
        return counts


def jumps(signal: Array, lag: int, spacing: int, least_ratio: float = 0.0, least_share: float = 0.5) -> Steps:
    """Find jumps: changes within `lag` samples that exceed a fraction of the largest such change.

    Parameters
    ----------
    signal : ndarray, shape (n_record, n_time)
    lag : int
        Largest duration of a jump [samples], at least 1.
    spacing : int
        Jumps closer than this to another one belong to it [samples].
    least_ratio : float
        Least ratio of largest to mean change; below it, a record has no jumps. This separates square waves
        from noise.
    least_share : float
        Fraction of the largest change that a jump must exceed.
    """
    n_change = max(signal.shape[1] - lag, 0)
    change = signal[:, lag:] - signal[:, :n_change]
    np.abs(change, out=change)
    largest = change.max(axis=1, initial=0.0)
    is_jumping = np.isfinite(largest) & (largest * n_change > least_ratio * change.sum(axis=1))
    least = np.where(is_jumping, least_share * largest, np.inf)
    record, first = np.divmod(np.flatnonzero(change > least[:, None]), max(n_change, 1))
    apart = (np.diff(first, prepend=-1) > spacing) | (np.diff(record, prepend=-1) != 0)
    return Steps(record[apart], first[apart] + lag)


def half_periods(
    n_record: int, n_time: int, sampling_frequency: float, period: float, start_time: float = 0.0
) -> Steps:
    """Middles and ends of the periods of a drive that started at time zero, the same in each record.

    Parameters
    ----------
    n_record, n_time : int
        Number of records, and samples per record.
    sampling_frequency, period, start_time : float
        Sampling frequency [Hz], period [s], and time of the first sample [s].
    """
    half, rounding = period / 2.0, 1e-9
    first = math.floor(start_time / half + rounding) + 1
    last = math.floor((start_time + (n_time - 1) / sampling_frequency) / half + rounding)
    instants = half * np.arange(first, last + 1) - start_time
    sample = np.ceil(instants * sampling_frequency - rounding * n_time).astype(np.intp)
    return Steps(np.repeat(np.arange(n_record), sample.size), np.tile(sample, n_record))
