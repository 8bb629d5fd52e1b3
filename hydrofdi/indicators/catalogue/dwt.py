"""RMS of the coefficients of the discrete wavelet transform, as in the paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.wavelet import (
    WaveletConfig,
    coefficient_rms,
    counted_coefficients,
    decomposition_filters,
    detail_rms,
    inner_coefficients,
    n_phase,
    root_mean_square,
    shortage,
)

_WRAPPED = {"periodization", "periodic"}
"""Extensions with which the first coefficients depend on the last samples."""


def phase_rms(signal: Array, wavelet: WaveletConfig) -> Array:
    """RMS of the details at every start phase, shape (..., n_phase, n_level).

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


class DwtOptions(ChannelOptions, WaveletConfig):
    """Options of `Dwt`."""


class Dwt(SingleChannelIndicator[DwtOptions]):
    """RMS of the detail and approximation coefficients of the discrete wavelet transform."""

    name = "dwt"
    version = 1
    source = (
        "Maddahi et al. (2015, the paper that hydrofdi reproduces); Goharrizi and Sepehri, IEEE Trans. Ind."
        " Electron. (2010)"
    )
    equation = "d_j = sqrt(mean over k of d_j[k]²), a_j alike; level j covers f_s/2^(j+1) to f_s/2^j"
    Options = DwtOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """d1 …, a1 …, and the details at each start phase if all phases are measured."""
        unit, levels = self.unit, range(1, self.options.levels + 1)
        # The paper's rule: leakage damps the hydraulic mode, which lies in the band of d2 or d3.
        falling = {2: Direction.FALLING, 3: Direction.FALLING}
        outputs = [
            Output(f"d{level}", unit, f"RMS of the details of level {level}", direction=falling.get(level))
            for level in levels
        ]
        outputs += [
            Output(f"a{level}", unit, f"RMS of the approximations of level {level}") for level in levels
        ]
        if self.options.phase == "all":
            phases = {"phase": n_phase(self.options.levels)}
            for each in outputs[: self.options.levels]:
                long_name = f"{each.long_name} at each phase"
                outputs.append(replace(each, name=f"{each.name}_phases", long_name=long_name, dims=phases))
        return tuple(outputs)

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the levels."""
        n_sample = records.n_time - self.options.latest_start
        return shortage(n_sample, self.options.name, self.options.levels)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,); over phases (n_record, n_phase)."""
        wavelet, signal = self.options, self.signal(records)
        rms = coefficient_rms(signal[:, wavelet.first_sample :], wavelet)
        values = {f"d{level + 1}": rms.detail[:, level] for level in range(wavelet.levels)}
        values |= {f"a{level + 1}": rms.approximation[:, level] for level in range(wavelet.levels)}
        if wavelet.phase == "all":
            details = phase_rms(signal, wavelet)
            values |= {f"d{level + 1}_phases": details[..., level] for level in range(wavelet.levels)}
        return values
