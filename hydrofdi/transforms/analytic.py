"""Analytic signal of a frequency band; its magnitude is the envelope of the oscillation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EDGE = 0.375
"""Width of each transition of the gain, as a fraction of the band; a sharper edge would ring longer."""


def analytic_signal(
    signal: Array, sampling_frequency: float, band: tuple[float, float]
) -> NDArray[np.complex128]:
    """Zero-delay analytic signal of a band; records are treated as periodic.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    sampling_frequency : float
        [Hz].
    band : (float, float)
        Lowest and highest frequency [Hz]; in between, the gain has raised-cosine transitions.

    Returns
    -------
    ndarray, shape (..., n_time)
        The real part is the band-pass signal, the imaginary part its Hilbert transform.
    """
    n_time = signal.shape[-1]
    gain = _gain(np.arange(n_time // 2 + 1) * (sampling_frequency / n_time), band)
    analytic: NDArray[np.complex128] = np.fft.ifft(2.0 * gain * np.fft.rfft(signal, axis=-1), n_time, axis=-1)
    return analytic


def _gain(frequency: Array, band: tuple[float, float]) -> Array:
    low, high = band
    inside = np.minimum(frequency - low, high - frequency) / (_EDGE * (high - low))
    gain: Array = np.sin(0.5 * np.pi * np.clip(inside, 0.0, 1.0)) ** 2
    return gain
