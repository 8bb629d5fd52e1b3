"""Spectra of records: Welch's power spectral density, RMS in bands, and short-time spectra."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def power_spectrum(signal: Array, sampling_frequency: float, segment: float = 2.0) -> tuple[Array, Array]:
    """Power spectral density by Welch's method: Hann windows, 50 % overlap, mean of each segment removed.

    Frequencies [Hz] and one-sided density (..., n_frequency), in the square of the signal's unit per Hz. A
    `segment` [s] is at most as long as the record.
    """
    from scipy.signal import welch

    n_segment = min(signal.shape[-1], round(segment * sampling_frequency))
    frequency, density = welch(signal, sampling_frequency, "hann", n_segment)
    return np.asarray(frequency, dtype=float), np.asarray(density, dtype=float)


def band_rms(
    signal: Array, sampling_frequency: float, bands: Sequence[tuple[float, float]], segment: float
) -> Array:
    """RMS (..., n_band) in bands [Hz] of the power spectral density.

    Each spectral line covers the interval halfway to its neighbours, so that contiguous bands contain the
    total power.
    """
    frequency, density = power_spectrum(signal, sampling_frequency, segment)
    half = frequency[1] / 2
    low, high = np.maximum(frequency - half, 0.0), np.minimum(frequency + half, sampling_frequency / 2)
    shares = [np.maximum(np.minimum(high, top) - np.maximum(low, bottom), 0) for bottom, top in bands]
    # A line whose interval is cut at an end still has the power of a whole one.
    weights = [2 * half * share / (high - low) for share in shares]
    return np.stack([np.sqrt(np.sum(density * weight, axis=-1)) for weight in weights], axis=-1)


def short_time_spectra(signal: Array, n_segment: int, hop: int) -> NDArray[np.complex128]:
    """Spectra of Hann-windowed segments, mean removed, scaled to amplitudes of sines.

    Shape (..., n_segments, n_segment // 2 + 1); a segment starts every `hop` samples. All segments are
    transformed at once; `scipy.signal.ShortTimeFFT` transforms them one by one and takes three to ten times
    as long.
    """
    from scipy.signal import get_window

    window = get_window("hann", n_segment)
    segments = np.lib.stride_tricks.sliding_window_view(signal, n_segment, axis=-1)[..., ::hop, :]
    # Half of a sine's amplitude is at the negative frequency, hence 2.
    segments = (segments - segments.mean(axis=-1, keepdims=True)) * (window * (2.0 / window.sum()))
    spectra: NDArray[np.complex128] = np.fft.rfft(segments, axis=-1)
    return spectra
