"""Undecimated wavelet transform (MODWT) of periodic records.

It has one coefficient per sample, so its RMS does not depend on where a record starts: the mean square of
level j is the mean over the 2^j start phases of a decimated transform. Coefficients are 2^(j/2) times those
of the MODWT, to match the scale of the decimated transform. Percival and Walden, Wavelet Methods for Time
Series Analysis (2000), chapter 5.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import CoefficientRms, decomposition_filters, n_phase, root_mean_square

Complex = NDArray[np.complex128]


def undecimated_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> CoefficientRms:
    """RMS of details and approximations of the undecimated transform of periodic records (..., n_time).

    Computed in the frequency domain by Parseval's theorem, without computing coefficients.
    """
    n_time = signal.shape[-1]
    # Parseval: the mean square of a filtered signal is its weighted power, no inverse transform needed.
    power = np.square(np.abs(np.fft.rfft(signal, axis=-1))) * _one_sided_weights(n_time)
    details, approximations = _gains(wavelet, n_time)
    return CoefficientRms(
        _root_of_sums(power, details) / n_time, _root_of_sums(power, approximations) / n_time
    )


def _root_of_sums(power: NDArray[np.float64], gains: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root of the power (..., n_frequency) weighted by each gain (n_level, n_frequency), record by record.

    With a matrix product, rounding would depend on the other records in the batch.
    """
    return np.stack([np.sqrt(np.sum(power * gain, axis=-1)) for gain in gains], axis=-1)


def inner_undecimated_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> CoefficientRms:
    """RMS of the undecimated coefficients that depend only on samples inside the record.

    Records are longer than `boundary_length`.
    """
    n_time = signal.shape[-1]
    spectrum = np.fft.rfft(signal, axis=-1)
    taps = decomposition_filters(wavelet)[0].size
    levels: list[list[NDArray[np.float64]]] = []
    for responses in _responses(wavelet, n_time):
        coefficients = (np.fft.irfft(spectrum * response, n_time, axis=-1) for response in responses)
        levels.append(
            [
                # Without the coefficients that reach back round the circle.
                root_mean_square(values[..., (n_phase(level) - 1) * (taps - 1) :])
                for level, values in enumerate(coefficients, 1)
            ]
        )
    details, approximations = (np.stack(rms, axis=-1) for rms in levels)
    return CoefficientRms(details, approximations)


def undecimated_coefficients(
    signal: NDArray[np.float64], wavelet: WaveletConfig
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Details and approximations (..., n_level, n_time) of periodic records (..., n_time).

    Coefficient t of level j depends on samples t − (2^j − 1)(n_tap − 1) to t.
    """
    n_time = signal.shape[-1]
    spectrum = np.fft.rfft(signal, axis=-1)[..., None, :]
    details, approximations = (
        np.fft.irfft(spectrum * response, n_time, axis=-1) for response in _responses(wavelet, n_time)
    )
    return details, approximations


def phase_detail_rms(details: NDArray[np.float64], first_sample: int) -> NDArray[np.float64]:
    """RMS (..., n_phase, n_level) of the coefficients of a decimated transform at each start phase.

    `details` are from `undecimated_coefficients`, the first of them at `first_sample` of the record, from
    whose start phases are counted.
    """
    n_level = details.shape[-2]
    rms = np.empty((*details.shape[:-2], n_phase(n_level), n_level))
    for level in range(n_level):
        distance = 2 ** (level + 1)
        for residue in range(distance):
            kept = details[..., level, (residue - 1 - first_sample) % distance :: distance]
            # Start phases that differ by the spacing of this level share its grid.
            rms[..., residue::distance, level] = root_mean_square(kept)[..., None]
    return rms


def boundary_length(wavelet: WaveletConfig) -> int:
    """Number of coefficients at the deepest level that depend on samples before the record."""
    low_pass, _ = decomposition_filters(wavelet)
    return (n_phase(wavelet.levels) - 1) * (low_pass.size - 1)


@lru_cache(maxsize=16)
def _responses(wavelet: WaveletConfig, n_time: int) -> tuple[Complex, Complex]:
    """Frequency responses of details and approximations, each (n_level, n_frequency)."""
    low_pass, high_pass = decomposition_filters(wavelet)
    places = np.arange(n_time // 2 + 1)
    approximation = np.ones(places.size, dtype=complex)
    details, approximations = [], []
    for level in range(wavelet.levels):
        # Taps 2^level samples apart have the response of 2^level times the frequency.
        details.append(approximation * _response(high_pass, places << level, n_time))
        approximation = approximation * _response(low_pass, places << level, n_time)
        approximations.append(approximation)
    return np.array(details), np.array(approximations)


@lru_cache(maxsize=16)
def _gains(wavelet: WaveletConfig, n_time: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared magnitudes of the frequency responses, each (n_level, n_frequency)."""
    details, approximations = (np.square(np.abs(response)) for response in _responses(wavelet, n_time))
    return details, approximations


def _response(taps: NDArray[np.float64], places: NDArray[np.int64], n_time: int) -> Complex:
    """Frequency response of a filter; frequencies in cycles per record."""
    # Taps beyond the length of the record wrap round.
    circular = np.bincount(np.arange(taps.size) % n_time, taps, n_time)
    # A response repeats with the sampling frequency.
    response: Complex = np.fft.fft(circular)[places % n_time]
    return response


def _one_sided_weights(n_time: int) -> NDArray[np.float64]:
    """Weight of each line of a one-sided spectrum in a sum over all frequencies."""
    weights = np.full(n_time // 2 + 1, 2.0)
    # The constant, and the line at half the sampling frequency, have no mirror image.
    weights[0] = 1.0
    if n_time % 2 == 0:
        weights[-1] = 1.0
    return weights
