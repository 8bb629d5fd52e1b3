"""Stretches of a record in which something holds, and how signals drift there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Stretches:
    """Samples of records that lie in stretches, one after another.

    Attributes
    ----------
    places : ndarray of int, shape (n_sample,)
        Of the samples in records (n_record, n_time) laid end to end.
    stretch : ndarray of int, shape (n_sample,)
        Number of the stretch that a sample lies in, ascending from 0.
    record : ndarray of int, shape (n_stretch,)
        Row of the record that a stretch lies in.
    time : ndarray, shape (n_sample,)
        Time of the samples, counted from the middle of their stretch, in samples.
    """

    places: Places
    stretch: Places
    record: Places
    time: Array

    def means(self, values: Array) -> Array:
        """Mean of values of the samples over each stretch, shape (n_stretch,)."""
        return np.bincount(self.stretch, values) / np.bincount(self.stretch)

    def durations(self, n_record: int) -> Array:
        """Number of samples of each record that lie in stretches."""
        return np.bincount(self.record[self.stretch], minlength=n_record).astype(np.float64)

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
            Per sample; NaN where a record has no stretch.
        """
        samples = signal.reshape(-1)[self.places]
        centred = samples - samples[np.searchsorted(self.stretch, self.stretch)]
        products = self.time * (centred if signs is None else signs[self.stretch] * centred)
        record, n_record = self.record[self.stretch], len(signal)
        slopes: Array = np.bincount(record, products, n_record) / np.bincount(
            record, np.square(self.time), n_record
        )
        return slopes


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
    n_time = holds.shape[1]
    edges = np.diff(holds.astype(np.int8), axis=1, prepend=0, append=0)
    record, first = np.nonzero(edges == 1)
    length = np.nonzero(edges == -1)[1] - first - settling
    long = length >= least
    record, first, length = record[long], first[long] + settling, length[long]
    stretch = np.repeat(np.arange(record.size), length)
    place = np.arange(stretch.size) - np.repeat(np.cumsum(length) - length, length)
    return Stretches(
        places=(record * n_time + first)[stretch] + place,
        stretch=stretch,
        record=record,
        time=place - 0.5 * (length[stretch] - 1.0),
    )
