"""Hum of the mains in a record."""

from __future__ import annotations

import numpy as np

from hydrofdi.records.batch import Array

_LOWEST = 20.0
_PERIODS = 16.0
"""Fewer periods of the mains in a record tell nothing."""


def hum_share(samples: Array, sampling_frequency: float, mains: float) -> float:
    """Share of the power above 20 Hz that lies at the mains frequency and its harmonics.

    Harmonics above half of the sampling frequency are looked for where they fold back to.

    Parameters
    ----------
    samples : ndarray, shape (n_time,)
    sampling_frequency : float
        [Hz].
    mains : float
        [Hz].
    """
    if samples.size < _PERIODS * sampling_frequency / mains or mains >= sampling_frequency / 2.0:
        return 0.0
    window = np.hanning(samples.size + 1)[:-1]
    power = np.abs(np.fft.rfft((samples - samples.mean()) * window)) ** 2
    step = sampling_frequency / samples.size
    frequency = np.arange(power.size) * step
    harmonics = mains * np.arange(1, int(sampling_frequency / 2.0 / mains) + 1)
    width = 2.0 * step
    at_line = np.zeros(power.size, dtype=bool)
    for harmonic in harmonics.tolist():
        at_line |= np.abs(frequency - harmonic) <= width
    counted = frequency >= _LOWEST
    total = float(power[counted].sum())
    return float(power[at_line & counted].sum()) / total if total > 0.0 else 0.0
