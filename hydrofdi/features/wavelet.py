"""Wavelet features: the RMS of the coefficients of a record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pywt
from numpy.typing import NDArray

from hydrofdi.config.wavelet import WaveletConfig


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
    """RMS of details and approximations of the discrete wavelet transform, in one pass.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
        Records, e.g. chamber-1 pressures [Pa].
    wavelet : WaveletConfig
        Wavelet, number of levels and extension at the ends of the record.
    """
    details, approximations = [], []
    approximation = signal
    for _ in range(wavelet.levels):
        approximation, detail = pywt.dwt(approximation, wavelet.name, mode=wavelet.extension, axis=-1)
        details.append(_rms(detail))
        approximations.append(_rms(approximation))
    return CoefficientRms(np.stack(details, axis=-1), np.stack(approximations, axis=-1))


def _rms(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    rms: NDArray[np.float64] = np.sqrt(np.mean(np.square(coefficients), axis=-1))
    return rms


def detail_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> NDArray[np.float64]:
    """RMS of all detail coefficients of each level of the discrete wavelet transform.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
        Records, e.g. chamber-1 pressures [Pa].
    wavelet : WaveletConfig
        Wavelet, number of levels and extension at the ends of the record.

    Returns
    -------
    ndarray, shape (..., n_level)
        RMS of d1, d2, …, in the unit of the signal.
    """
    return coefficient_rms(signal, wavelet).detail


def level_bands(sampling_frequency: float, levels: int) -> list[tuple[float, float]]:
    """Nominal frequency bands of d1, d2, … [Hz]: level j covers f_s/2^(j+1) to f_s/2^j."""
    return [(sampling_frequency / 2 ** (j + 1), sampling_frequency / 2**j) for j in range(1, levels + 1)]


def detail_coefficients(
    signal: NDArray[np.float64], wavelet: WaveletConfig, level: int, time: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The detail coefficients of one level, and the instants that they belong to.

    Parameters
    ----------
    signal : ndarray, shape (n_time,)
    wavelet : WaveletConfig
    level : int
        1 … ``wavelet.levels``.
    time : ndarray, shape (n_time,)
        Sampling instants [s].

    Returns
    -------
    instants : ndarray, shape (n_coefficient,)
        Spread evenly over the record [s].
    coefficients : ndarray, shape (n_coefficient,)
        In the unit of the signal.
    """
    details = pywt.wavedec(signal, wavelet.name, mode=wavelet.extension, level=wavelet.levels)[-level]
    return np.linspace(time[0], time[-1], details.size), details


def boundary_shares(n_sample: int, wavelet: WaveletConfig) -> list[float]:
    """Share of each level's detail coefficients that depend on the extension of the record.

    Parameters
    ----------
    n_sample : int
    wavelet : WaveletConfig

    Returns
    -------
    list of float
        d1 first; 0 … 1.
    """
    taps = pywt.Wavelet(wavelet.name).dec_len
    shares = []
    length, first, last = n_sample, 0, n_sample - 1
    for _ in range(wavelet.levels):
        length = pywt.dwt_coeff_len(length, taps, wavelet.extension)
        first, last = -(-(first + taps - 2) // 2), (last - 1) // 2
        shares.append(1.0 - max(0, last - first + 1) / length)
    return shares


def white_noise_gains(wavelet: WaveletConfig) -> list[float]:
    """RMS of each level's detail coefficients of white noise, over its standard deviation.

    1 for an orthogonal wavelet; in general the norm of the filter from the record to the level.

    Parameters
    ----------
    wavelet : WaveletConfig

    Returns
    -------
    list of float
        d1 first [-].
    """
    filters = pywt.Wavelet(wavelet.name)
    approximation, gains = np.ones(1), []
    for level in range(wavelet.levels):
        detail = _spread_convolution(approximation, filters.dec_hi, 2**level)
        approximation = _spread_convolution(approximation, filters.dec_lo, 2**level)
        gains.append(float(np.linalg.norm(detail)))
    return gains


def _spread_convolution(
    signal: NDArray[np.float64], taps: Sequence[float], distance: int
) -> NDArray[np.float64]:
    """A signal convolved with taps that are so many samples apart."""
    result = np.zeros(signal.size + distance * (len(taps) - 1))
    for position, tap in enumerate(taps):
        first = distance * position
        result[first : first + signal.size] += tap * signal
    return result
