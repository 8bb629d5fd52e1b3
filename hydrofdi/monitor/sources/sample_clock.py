"""Instants of samples without a time stamp."""

from __future__ import annotations

import numpy as np

from hydrofdi.records.batch import Array


class SampleClock:
    """Counts samples at a sampling frequency.

    Parameters
    ----------
    sampling_frequency : float
        [Hz]
    n_sample : int
        Number of earlier samples.
    """

    def __init__(self, sampling_frequency: float, n_sample: int = 0) -> None:
        self.sampling_frequency, self.n_sample = sampling_frequency, n_sample

    def take(self, n_time: int) -> Array:
        """Instants of the next samples [s], shape (n_time,)."""
        first, self.n_sample = self.n_sample, self.n_sample + n_time
        return np.arange(first, self.n_sample) / self.sampling_frequency

    def skip(self, n_time: int) -> None:
        """Leave a gap for samples that cannot be read."""
        self.n_sample += n_time
