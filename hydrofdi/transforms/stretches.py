"""Stretches of a record in which a condition holds, and the drift of signals in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Stretches:
    """Stretches of records, and their samples, concatenated.

    Attributes
    ----------
    record, first, length : ndarray of int, shape (n_stretch,)
        Row of the record, index of the first sample in `places`, and number of samples.
    places : ndarray of int, shape (n_sample,)
        Flat indices of the samples in an array (n_record, n_time).
    time : ndarray, shape (n_sample,)
        Time from the middle of the stretch [samples].
    """

    record: Places
    first: Places
    length: Places
    places: Places
    time: Array

    def means(self, signal: Array) -> Array:
        """Mean of a signal (n_record, n_time) in each stretch, shape (n_stretch,)."""
        return self._sums(signal.reshape(-1)[self.places]) / self.length

    def n_sample(self, n_record: int) -> Array:
        """Number of samples in stretches, for each record, shape (n_record,)."""
        return np.bincount(self.record, self.length, n_record).astype(np.float64)

    def drifts(self, signal: Array, signs: Array | None = None) -> Array:
        """Least-squares slope of a signal, common to all stretches of a record.

        Parameters
        ----------
        signal : ndarray, shape (n_record, n_time)
        signs : ndarray, shape (n_stretch,), optional
            Factor applied to the signal in each stretch.

        Returns
        -------
        ndarray, shape (n_record,)
            Per sample; NaN if a record has no stretch.
        """
        samples = signal.reshape(-1)[self.places]
        samples -= np.repeat(samples[self.first], self.length)
        samples *= self.time
        products, squares = self._sums(samples), self.length * (np.square(self.length) - 1.0) / 12.0
        if signs is not None:
            products *= signs
        slopes: Array = np.bincount(self.record, products, len(signal)) / np.bincount(
            self.record, squares, len(signal)
        )
        return slopes

    def _sums(self, samples: Array) -> Array:
        sums: Array = np.add.reduceat(samples, self.first) if self.first.size else np.zeros(0)
        return sums


def stretches_where(holds: NDArray[np.bool_], settling: int, least: int) -> Stretches:
    """Find the stretches in which a condition holds.

    Parameters
    ----------
    holds : ndarray of bool, shape (n_record, n_time)
    settling : int
        Number of samples excluded at the start of each stretch.
    least : int
        Least number of remaining samples, at least 2; shorter stretches are excluded.
    """
    n_record, n_time = holds.shape
    framed = np.zeros((n_record, n_time + 2), dtype=bool)
    framed[:, 1:-1] = holds
    row, edge = np.divmod(np.flatnonzero(framed[:, 1:] != framed[:, :-1]), n_time + 1)
    record, start, length = row[::2], edge[::2] + settling, edge[1::2] - edge[::2] - settling
    long = length >= least
    record, start, length = record[long], start[long], length[long]
    first = np.cumsum(length) - length
    within = np.arange(length.sum()) - np.repeat(first, length)
    return Stretches(
        record=record,
        first=first,
        length=length,
        places=within + np.repeat(record * n_time + start, length),
        time=within - np.repeat(0.5 * (length - 1.0), length),
    )
