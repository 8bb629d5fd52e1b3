"""Wavelet features: RMS of the coefficients of a record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.transforms.configuration import WaveletConfig


@dataclass(frozen=True)
class CoefficientRms:
    """RMS of all coefficients of each level, in the unit of the signal.

    Attributes
    ----------
    detail : ndarray, shape (..., n_level)
        d1, d2, ….
    approximation : ndarray, shape (..., n_level)
        a1, a2, …; a constant c gives 2^(j/2) c at level j.
    """

    detail: NDArray[np.float64]
    approximation: NDArray[np.float64]


def coefficient_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> CoefficientRms:
    """RMS of details and approximations of the discrete wavelet transform of records (..., n_time)."""
    from pywt import dwt

    details, approximations = [], []
    approximation = signal
    for inside in counted_coefficients(signal.shape[-1], wavelet):
        approximation, detail = dwt(approximation, wavelet.name, mode=wavelet.extension, axis=-1)
        details.append(root_mean_square(detail[..., inside]))
        approximations.append(root_mean_square(approximation[..., inside]))
    return CoefficientRms(np.stack(details, axis=-1), np.stack(approximations, axis=-1))


def n_phase(levels: int) -> int:
    """Number of start phases of a decimated transform: the period of its grid in samples."""
    return 1 << levels


def root_mean_square(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root mean square over the last axis."""
    rms: NDArray[np.float64] = np.sqrt(np.mean(np.square(coefficients), axis=-1))
    return rms


def detail_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> NDArray[np.float64]:
    """RMS (..., n_level) of the details of the discrete wavelet transform of records (..., n_time)."""
    return coefficient_rms(signal, wavelet).detail


def shortage(n_sample: int, wavelet: str, levels: int) -> str | None:
    """Message if a record is too short for the levels of a decimated transform, else None."""
    from pywt import Wavelet, dwt_max_level

    length = Wavelet(wavelet).dec_len
    if dwt_max_level(max(n_sample, 1), length) >= levels:
        return None
    needed = (length - 1) * 2**levels
    return (
        f"{n_sample} samples are too few for level {levels} of {wavelet}: it needs {needed}; take longer"
        " records or windows"
    )


def level_bands(sampling_frequency: float, levels: int) -> list[tuple[float, float]]:
    """Nominal frequency bands of d1, d2, … [Hz]: level j covers f_s/2^(j+1) to f_s/2^j."""
    return [(sampling_frequency / 2 ** (j + 1), sampling_frequency / 2**j) for j in range(1, levels + 1)]


def detail_coefficients(
    signal: NDArray[np.float64], wavelet: WaveletConfig, level: int, time: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Instants, spread evenly over the record, and detail coefficients of one level, 1 … ``levels``."""
    from pywt import wavedec

    details = wavedec(signal, wavelet.name, mode=wavelet.extension, level=wavelet.levels)[-level]
    return np.linspace(time[0], time[-1], details.size), details


def counted_coefficients(n_sample: int, wavelet: WaveletConfig) -> list[slice]:
    """Slice of the coefficients that are used, for each level."""
    if wavelet.boundary == "kept":
        return [slice(None)] * wavelet.levels
    return inner_coefficients(n_sample, wavelet)


def inner_coefficients(n_sample: int, wavelet: WaveletConfig) -> list[slice]:
    """Slice of the coefficients that depend only on samples inside the record, for each level."""
    from pywt import Wavelet

    taps, first, last, inside = Wavelet(wavelet.name).dec_len, 0, n_sample - 1, []
    for _ in range(wavelet.levels):
        # Coefficient k depends on samples 2k + 2 − taps to 2k + 1 of the level before; rounded up and down.
        first, last = -(-(first + taps - 2) // 2), (last - 1) // 2
        inside.append(slice(first, last + 1))
    return inside


def decomposition_filters(wavelet: WaveletConfig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Taps of the low-pass and high-pass decomposition filters."""
    from pywt import Wavelet

    filters = Wavelet(wavelet.name)
    return np.array(filters.dec_lo), np.array(filters.dec_hi)


def percentage_change(
    healthy_rms: NDArray[np.float64], faulty_rms: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Relative decrease δ [%] of the RMS from the healthy to the faulty state. Equation (13)."""
    change: NDArray[np.float64] = 100.0 * (healthy_rms - faulty_rms) / healthy_rms  # (13)
    return change
