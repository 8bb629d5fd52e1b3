"""Spectra of records: Welch's power spectrum, its share in bands, and spectra over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def power_spectrum(signal: Array, sampling_frequency: float, segment: float = 2.0) -> tuple[Array, Array]:
    """Power spectral density after Welch: Hann windows that overlap by half, each segment less its mean.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    sampling_frequency : float
        [Hz].
    segment : float
        Length of a segment [s]; the record's own length where that is shorter.

    Returns
    -------
    frequency : ndarray, shape (n_frequency,)
        From zero to half of the sampling frequency [Hz].
    density : ndarray, shape (..., n_frequency)
        One-sided, in the square of the signal's unit per Hz.
    """
    from scipy.signal import welch

    n_segment = min(signal.shape[-1], round(segment * sampling_frequency))
    frequency, density = welch(signal, sampling_frequency, "hann", n_segment)
    return np.asarray(frequency, dtype=float), np.asarray(density, dtype=float)


def band_rms(
    signal: Array, sampling_frequency: float, bands: Sequence[tuple[float, float]], segment: float
) -> Array:
    """RMS in bands of the power spectral density.

    Each frequency stands for what lies halfway to its neighbours, so that bands without a gap share the
    whole power.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    sampling_frequency : float
        [Hz].
    bands : sequence of (float, float)
        Lowest and highest frequency [Hz].
    segment : float
        Length of Welch's segments [s].

    Returns
    -------
    ndarray, shape (..., n_band)
        In the unit of the signal.
    """
    frequency, density = power_spectrum(signal, sampling_frequency, segment)
    half = frequency[1] / 2
    low, high = np.maximum(frequency - half, 0.0), np.minimum(frequency + half, sampling_frequency / 2)
    shares = [np.maximum(np.minimum(high, top) - np.maximum(low, bottom), 0) for bottom, top in bands]
    weights = [2 * half * share / (high - low) for share in shares]
    return np.stack([np.sqrt(np.sum(density * weight, axis=-1)) for weight in weights], axis=-1)


def short_time_spectra(signal: Array, n_segment: int, hop: int) -> NDArray[np.complex128]:
    """Spectra of Hann-windowed segments, each less its mean, as amplitudes of sines.

    One transform of all segments: `scipy.signal.ShortTimeFFT` takes them one by one, in three to ten times
    the time.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    n_segment, hop : int
        Length of a segment, and from one to the next [samples].

    Returns
    -------
    ndarray, shape (..., n_segments, n_segment // 2 + 1)
        In the unit of the signal; the size at a frequency is the amplitude of a sine there.
    """
    from scipy.signal import get_window

    window = get_window("hann", n_segment)
    segments = np.lib.stride_tricks.sliding_window_view(signal, n_segment, axis=-1)[..., ::hop, :]
    segments = (segments - segments.mean(axis=-1, keepdims=True)) * (window * (2.0 / window.sum()))
    spectra: NDArray[np.complex128] = np.fft.rfft(segments, axis=-1)
    return spectra
