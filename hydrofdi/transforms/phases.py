"""Details of a decimated transform at every start phase; parts common to the phases are computed once.

At level j, phase p has the coefficients of phase p − 2^j, shifted by one, except for the first ones, which
depend on the first samples. So level j needs 2^j transforms, and the first coefficients of each phase are
computed from the head of its record.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import (
    counted_coefficients,
    decomposition_filters,
    detail_rms,
    inner_coefficients,
    n_phase,
    root_mean_square,
)

Array = NDArray[np.float64]

_WRAPPED = {"periodization", "periodic"}
"""Extensions with which the first coefficients depend on the last samples."""


def phase_rms(signal: Array, wavelet: WaveletConfig) -> Array:
    """RMS of the details at every start phase.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    wavelet : WaveletConfig

    Returns
    -------
    ndarray, shape (..., n_phase, n_level)
        Phase p is bit-identical to a transform of the record from sample p on.
    """
    phases, n_time = range(n_phase(wavelet.levels)), signal.shape[-1]
    if wavelet.extension in _WRAPPED or n_time < len(phases) * 4 * _head_length(wavelet):
        return np.stack([detail_rms(signal[..., phase:], wavelet) for phase in phases], axis=-2)
    rms = np.empty((*signal.shape[:-1], len(phases), wavelet.levels))
    counted = [counted_coefficients(n_time - phase, wavelet) for phase in phases]
    for level, of_phases in enumerate(_details(signal, wavelet)):
        for phase, details in enumerate(of_phases):
            rms[..., phase, level] = root_mean_square(details[..., counted[phase][level]])
    return rms


def _details(signal: Array, wavelet: WaveletConfig) -> Iterator[Iterator[Array]]:
    """The details of each level, phase by phase."""
    from pywt import dwt

    phases, length = range(n_phase(wavelet.levels)), _head_length(wavelet)
    records, heads = [signal], sliding_window_view(signal, length, axis=-1)
    for _ in range(wavelet.levels):
        starts = np.stack([_joined(heads, phase, records, 3 * length) for phase in phases], axis=-2)
        records += [_joined(heads, phase, records) for phase in range(len(records), 2 * len(records))]
        pairs = [dwt(record, wavelet.name, mode=wavelet.extension, axis=-1) for record in records]
        records, details = ([pair[kind] for pair in pairs] for kind in (0, 1))
        of_starts = dwt(starts, wavelet.name, mode=wavelet.extension, axis=-1)
        heads, detail_heads = (coefficients[..., :length] for coefficients in of_starts)
        yield (_joined(detail_heads, phase, details) for phase in phases)


def _joined(heads: Array, phase: int, records: list[Array], length: int | None = None) -> Array:
    """Coefficients of a phase: its own first ones, then those shared with an earlier phase."""
    later, earlier = divmod(phase, len(records))
    shared = records[earlier][..., later : None if length is None else later + length]
    if later == 0:
        return shared
    head = heads[..., phase, :]
    return np.concatenate([head, shared[..., head.shape[-1] :]], axis=-1)


def _head_length(wavelet: WaveletConfig) -> int:
    """Number of coefficients to compute separately for each phase.

    At least the number that depends on the first samples, and the number of filter taps.
    """
    first_inner: int = inner_coefficients(1, wavelet)[-1].start
    return decomposition_filters(wavelet)[0].size + first_inner
