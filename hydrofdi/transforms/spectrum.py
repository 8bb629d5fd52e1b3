"""Power spectrum of a record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def power_spectrum(
    signal: NDArray[np.float64], sampling_frequency: float, segment: float = 2.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Power spectral density after Welch: Hann windows that overlap by half, each segment less its mean.

    Parameters
    ----------
    signal : ndarray, shape (n_time,)
    sampling_frequency : float
        [Hz].
    segment : float
        Length of a segment [s]; the record's own length where that is shorter.

    Returns
    -------
    frequency : ndarray, shape (n_frequency,)
        From zero to half of the sampling frequency [Hz].
    density : ndarray, shape (n_frequency,)
        One-sided, in the square of the signal's unit per Hz.
    """
    n_segment = min(signal.size, round(segment * sampling_frequency))
    window = np.hanning(n_segment + 1)[:-1]
    starts = range(0, signal.size - n_segment + 1, max(1, n_segment // 2))
    pieces = np.stack([signal[start : start + n_segment] for start in starts])
    pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * window
    power = np.mean(np.abs(np.fft.rfft(pieces, axis=1)) ** 2, axis=0)
    density = power / (sampling_frequency * np.sum(window**2))
    density[1 : None if n_segment % 2 else -1] *= 2.0
    frequency = np.fft.rfftfreq(n_segment, 1.0 / sampling_frequency)
    return np.asarray(frequency, dtype=float), np.asarray(density, dtype=float)
