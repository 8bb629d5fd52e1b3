"""Mains hum in a record: narrow steady spectral lines. A decaying mode does not count."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array

_LOWEST = 20.0
_PERIODS = 16.0
"""Fewest periods of the mains in a record that is checked."""
_PERIODS_OF_PART = 8.0
"""Periods of the mains in each part of a record. The amplitudes of the parts are compared."""
_STEADY = 0.7
"""Least ratio of a steady line's lower amplitudes (their first quartile over the parts) to the median. It is
1 for a sine, 0.64 for narrow-band noise (Rayleigh), and near 0 for a mode that decays between strokes.
Clipping may hide a line for a quarter of a record."""


def hum_share(samples: Array, sampling_frequency: float, mains: float) -> float:
    """Share of the power above 20 Hz in steady lines at the mains frequency and its harmonics.

    A line is steady if its amplitude lasts through the record, also while the machine rests.

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
    power = _spectrum(samples - samples.mean()) ** 2
    step = sampling_frequency / samples.size
    frequency = np.arange(power.size) * step
    harmonics = mains * np.arange(1, int(sampling_frequency / 2.0 / mains) + 1, dtype=np.float64)
    width = 2.0 * step
    at_line = np.zeros(power.size, dtype=bool)
    for harmonic in harmonics[_are_steady(samples, sampling_frequency, mains, harmonics)].tolist():
        at_line |= np.abs(frequency - harmonic) <= width
    counted = frequency >= _LOWEST
    total = float(power[counted].sum())
    return float(power[at_line & counted].sum()) / total if total > 0.0 else 0.0


def _are_steady(
    samples: Array, sampling_frequency: float, mains: float, harmonics: Array
) -> NDArray[np.bool_]:
    """Whether the amplitude at each harmonic lasts, shape (n_harmonic,)."""
    n_part = round(_PERIODS_OF_PART * sampling_frequency / mains)
    parts = np.lib.stride_tricks.sliding_window_view(samples, n_part)[:: max(1, n_part // 2)]
    amplitudes = _spectrum(parts - parts.mean(axis=1, keepdims=True))
    places = np.minimum(np.rint(harmonics * n_part / sampling_frequency).astype(int), n_part // 2)
    low, median = np.quantile(amplitudes[:, places], [0.25, 0.5], axis=0)
    steady: NDArray[np.bool_] = low > _STEADY * median
    return steady


def _spectrum(samples: Array) -> Array:
    """Amplitude spectrum of samples along their last axis, with a Hann window."""
    window = np.hanning(samples.shape[-1] + 1)[:-1]
    amplitudes: Array = np.abs(np.fft.rfft(samples * window))
    return amplitudes
