"""Ridge of a short-time Fourier transform: the strongest frequency of each segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.transforms.spectrum import short_time_spectra

Array = NDArray[np.float64]

_ROUNDING = 1e-12
"""Amplitude relative to the largest sample below which a segment counts as constant (rounding)."""


def spectral_ridge(
    signal: Array, sampling_frequency: float, band: tuple[float, float], n_segment: int, hop: int
) -> tuple[Array, Array]:
    """Strongest frequency in a band and its amplitude, for each segment.

    Both are interpolated between the largest spectral line and its larger neighbour, which is exact for a
    long tone: Grandke, IEEE Trans. Instrum. Meas. 32(2) (1983) 350.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    sampling_frequency : float
        [Hz].
    band : (float, float)
        Lowest and highest frequency [Hz]; at least two lines of the spectrum wide.
    n_segment, hop : int
        Length of a segment, and distance between the starts of adjacent segments [samples].

    Returns
    -------
    frequency : ndarray, shape (..., n_segments)
        [Hz]
    amplitude : ndarray, shape (..., n_segments)
        In the unit of the signal; zero if the segment is constant.
    """
    spacing = sampling_frequency / n_segment
    first, last = _lines(band, spacing, n_segment // 2)
    spectra = short_time_spectra(signal, n_segment, hop)[..., first - 1 : last + 2]
    rounding = _ROUNDING * np.abs(signal).max(axis=-1)[..., None]
    size = np.maximum(np.abs(spectra), rounding[..., None])
    peak = 1 + np.argmax(size[..., 1:-1], axis=-1)[..., None]
    before, at, after = (np.take_along_axis(size, peak + side, axis=-1)[..., 0] for side in (-1, 0, 1))
    ratio = np.maximum(before, after) / at
    distance = np.clip((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0, 0.5)
    side = np.where(after > before, distance, -distance)
    frequency = np.clip((first - 1 + peak[..., 0] + side) * spacing, *band)
    amplitude = at * (1.0 - np.square(distance)) / np.sinc(distance)
    return frequency, np.where(at > rounding, amplitude, 0.0)


def _lines(band: tuple[float, float], spacing: float, n_line: int) -> tuple[int, int]:
    """First and last spectral line that lie in a band and have a neighbour on either side."""
    return max(1, int(np.ceil(band[0] / spacing))), min(n_line - 1, int(np.floor(band[1] / spacing)))
