"""Wavelet transforms of records, decimated and undecimated: the RMS of their coefficients.

The undecimated transform (MODWT) has one coefficient per sample, so its RMS does not depend on where a record
starts: the mean square of level j is the mean over the 2^j start phases of a decimated transform.
Coefficients are 2^(j/2) times those of the MODWT, to match the scale of the decimated transform. Percival and
Walden, Wavelet Methods for Time Series Analysis (2000), chapter 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from hydrofdi.settings.messages import similar
from hydrofdi.settings.quantities import Section


def _known_wavelet(name: str) -> str:
    from pywt import wavelist

    known = wavelist(kind="discrete")
    if name not in known:
        hint = similar(name, known) or ", such as 'db8'"
        raise ValueError(f"{name!r} is not a discrete wavelet of PyWavelets{hint}")
    return name


def _phase(value: Any) -> Any:
    if value == "all" or (isinstance(value, int) and not isinstance(value, bool) and value >= 0):
        return value
    raise ValueError(f"must be an integer from 0 to 2^levels − 1, or 'all'; found {value!r}")


WaveletName = Annotated[str, AfterValidator(_known_wavelet)]
"""Name of a discrete wavelet in PyWavelets."""

Levels = Annotated[int, Field(strict=True, ge=1, le=20)]
"""Number of levels of a transform."""

Extension = Literal[
    "symmetric", "periodization", "zero", "constant", "periodic", "smooth", "reflect",
    "antisymmetric", "antireflect",
]  # fmt: skip
"""Signal extension at the ends of a record; names as in PyWavelets."""


class WaveletConfig(Section):
    """Discrete wavelet transform of the chamber-1 pressure."""

    name: WaveletName = "db8"
    """Name in PyWavelets. db8 has 8 vanishing moments and 16 taps."""

    levels: Levels = 5
    """Number of levels; d1 is the finest detail."""

    extension: Extension = "symmetric"
    """Extension of the record at its ends."""

    boundary: Literal["kept", "left_out"] = "kept"
    """Whether coefficients that depend on the extension are used."""

    phase: Annotated[int | Literal["all"], Field(union_mode="left_to_right"), BeforeValidator(_phase)] = 0
    """First sample of the analysed record, counted after ``analysis.discard``. The transform is decimated, so
    its coefficients depend on where the grid of 2^levels samples starts. ``all`` measures every phase from 0
    to 2^levels − 1 in addition to phase 0."""

    @model_validator(mode="after")
    def _phase_is_one_of_the_grid(self) -> Self:
        if isinstance(self.phase, int) and self.phase >= 2**self.levels:
            raise ValueError(
                f"phase = {self.phase} must be below 2^levels = {2**self.levels}, where the phases repeat"
            )
        return self

    @model_validator(mode="after")
    def _inner_coefficients_are_known(self) -> Self:
        if self.boundary == "left_out" and self.extension == "periodization":
            raise ValueError("boundary = left_out cannot be combined with extension = periodization")
        return self

    @property
    def first_sample(self) -> int:
        """First sample of the analysed record."""
        return self.phase if isinstance(self.phase, int) else 0

    @property
    def latest_start(self) -> int:
        """Largest phase that is measured."""
        return self.phase if isinstance(self.phase, int) else 2**self.levels - 1


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


Complex = NDArray[np.complex128]


def undecimated_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> CoefficientRms:
    """RMS of details and approximations of the undecimated transform of periodic records (..., n_time).

    Computed in the frequency domain by Parseval's theorem, without computing coefficients.
    """
    n_time = signal.shape[-1]
    # Parseval: the mean square of a filtered signal is its weighted power, no inverse transform needed.
    power = np.square(np.abs(np.fft.rfft(signal, axis=-1))) * _one_sided_weights(n_time)
    return CoefficientRms(*(_root_of_sums(power, gains) / n_time for gains in _gains(wavelet, n_time)))


def _root_of_sums(power: NDArray[np.float64], gains: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root of the power (..., n_frequency) weighted by each gain (n_level, n_frequency), record by record.

    With a matrix product, rounding would depend on the other records in the batch.
    """
    return np.stack([np.sqrt(np.sum(power * gain, axis=-1)) for gain in gains], axis=-1)


def inner_undecimated_rms(signal: NDArray[np.float64], wavelet: WaveletConfig) -> CoefficientRms:
    """RMS of the undecimated coefficients that depend only on samples inside the record.

    Records are longer than `boundary_length`.
    """
    reach = decomposition_filters(wavelet)[0].size - 1
    rms = np.empty((2, *signal.shape[:-1], wavelet.levels))
    for kind, coefficients in enumerate(undecimated_coefficients(signal, wavelet)):
        for level in range(wavelet.levels):
            # Without the coefficients that reach back round the circle.
            inside = coefficients[..., level, (n_phase(level + 1) - 1) * reach :]
            rms[kind, ..., level] = root_mean_square(inside)
    return CoefficientRms(*rms)


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
