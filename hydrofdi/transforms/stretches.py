"""Stretches of a record in which something holds, and how signals drift there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Stretches:
    """Stretches of records, and their samples one stretch after another.

    Attributes
    ----------
    record, first, length : ndarray of int, shape (n_stretch,)
        Row of the record that a stretch lies in, its first sample among all, and how many it has.
    places : ndarray of int, shape (n_sample,)
        Of the samples in records (n_record, n_time) laid end to end.
    time : ndarray, shape (n_sample,)
        Time of the samples, counted from the middle of their stretch, in samples.
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
        """Number of samples of each record that lie in stretches."""
        return np.bincount(self.record, self.length, n_record).astype(np.float64)

    def drifts(self, signal: Array, signs: Array | None = None) -> Array:
        """Common slope of a signal in the stretches of each record, by least squares.

        Parameters
        ----------
        signal : ndarray, shape (n_record, n_time)
        signs : ndarray, shape (n_stretch,), optional
            Factor of the signal in each stretch.

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
    """The stretches in which something holds.

    Parameters
    ----------
    holds : ndarray of bool, shape (n_record, n_time)
    settling : int
        Number of samples at the start of each stretch that are left out.
    least : int
        Stretches with fewer samples after these do not count; at least 2.
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
