"""RMS of wavelet coefficients: dwt as in the paper, modwt, wavelet_packet and a4."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi import transforms
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import ChannelOptions, Indicator, Output, SingleChannelIndicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import Section

_WRAPPED = {"periodization", "periodic"}
"""Extensions with which the first coefficients depend on the last samples."""


def phase_rms(signal: Array, wavelet: transforms.WaveletConfig) -> Array:
    """RMS of the details at every start phase, shape (..., n_phase, n_level).

    Phase p is bit-identical to a transform of the record from sample p on.
    """
    phases, n_time = range(transforms.n_phase(wavelet.levels)), signal.shape[-1]
    if wavelet.extension in _WRAPPED or n_time < len(phases) * 4 * _head_length(wavelet):
        return np.stack([transforms.detail_rms(signal[..., phase:], wavelet) for phase in phases], axis=-2)
    rms = np.empty((*signal.shape[:-1], len(phases), wavelet.levels))
    counted = [transforms.counted_coefficients(n_time - phase, wavelet) for phase in phases]
    for level, of_phases in enumerate(_details(signal, wavelet)):
        for phase, details in enumerate(of_phases):
            rms[..., phase, level] = transforms.root_mean_square(details[..., counted[phase][level]])
    return rms


def _details(signal: Array, wavelet: transforms.WaveletConfig) -> Iterator[Iterator[Array]]:
    """The details of each level, phase by phase."""
    from pywt import dwt

    phases, length = range(transforms.n_phase(wavelet.levels)), _head_length(wavelet)
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


def _head_length(wavelet: transforms.WaveletConfig) -> int:
    """Number of coefficients to compute separately for each phase.

    At least the number that depends on the first samples, and the number of filter taps.
    """
    first_inner: int = transforms.inner_coefficients(1, wavelet)[-1].start
    return transforms.decomposition_filters(wavelet)[0].size + first_inner


class DwtOptions(ChannelOptions, transforms.WaveletConfig):
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
            phases = {"phase": transforms.n_phase(self.options.levels)}
            for each in outputs[: self.options.levels]:
                long_name = f"{each.long_name} at each phase"
                outputs.append(replace(each, name=f"{each.name}_phases", long_name=long_name, dims=phases))
        return tuple(outputs)

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the levels."""
        n_sample = records.n_time - self.options.latest_start
        return transforms.shortage(n_sample, self.options.name, self.options.levels)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,); over phases (n_record, n_phase)."""
        wavelet, signal = self.options, self.signal(records)
        rms = transforms.coefficient_rms(signal[:, wavelet.first_sample :], wavelet)
        values = {f"d{level + 1}": rms.detail[:, level] for level in range(wavelet.levels)}
        values |= {f"a{level + 1}": rms.approximation[:, level] for level in range(wavelet.levels)}
        if wavelet.phase == "all":
            details = phase_rms(signal, wavelet)
            values |= {f"d{level + 1}_phases": details[..., level] for level in range(wavelet.levels)}
        return values


class ModwtOptions(ChannelOptions):
    """Options of `Modwt`."""

    wavelet: transforms.WaveletName = "db8"
    """Name in PyWavelets."""

    levels: transforms.Levels = 5
    """Number of levels; d1 is the finest detail."""

    boundary: Literal["left_out", "circle"] = "left_out"
    """``left_out``: only coefficients that depend solely on samples of the record are used. ``circle``: the
    record is extended periodically, which suits an integer number of periods of a settled motion; if its ends
    do not match, the jump dominates the fine details."""

    @property
    def transform(self) -> transforms.WaveletConfig:
        """The wavelet and its levels."""
        return transforms.WaveletConfig(name=self.wavelet, levels=self.levels)


class Modwt(SingleChannelIndicator[ModwtOptions]):
    """RMS of the coefficients of the undecimated wavelet transform: dwt averaged over all start phases."""

    name = "modwt"
    version = 1
    source = "Percival and Walden, Wavelet Methods for Time Series Analysis (2000), chapter 5"
    equation = "d_j = sqrt(2^j · mean over t of W_j[t]²), W_j: MODWT; level j covers f_s/2^(j+1) to f_s/2^j"
    Options = ModwtOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """d1 …, a1 …, scaled like decimated coefficients."""
        kinds = {"d": "details", "a": "approximations"}
        return tuple(
            Output(f"{letter}{level}", self.unit, f"RMS of the undecimated {kind} of level {level}")
            for letter, kind in kinds.items()
            for level in range(1, self.options.levels + 1)
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is shorter than the longest filter."""
        options, longest = self.options, transforms.boundary_length(self.options.transform) + 1
        if records.n_time < longest:
            return (
                f"{options.levels} levels of {options.wavelet} need {longest} samples, not {records.n_time}"
            )
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        measure = (
            transforms.undecimated_rms
            if self.options.boundary == "circle"
            else transforms.inner_undecimated_rms
        )
        rms = measure(self.signal(records), self.options.transform)
        levels = range(self.options.levels)
        return {f"d{level + 1}": rms.detail[:, level] for level in levels} | {
            f"a{level + 1}": rms.approximation[:, level] for level in levels
        }


def packet_coefficients(
    signal: NDArray[np.float64], wavelet: str, level: int, extension: str
) -> NDArray[np.float64]:
    """Wavelet-packet coefficients of all nodes of a level, in frequency order.

    Shape (..., 2^level, n_coefficient); node k nominally covers k to k + 1 times f_s/2^(level+1).
    """
    from pywt import dwt

    nodes = signal[..., None, :]
    for _ in range(level):
        children = np.stack(dwt(nodes, wavelet, mode=extension, axis=-1), axis=-2)
        # Decimation mirrors the spectrum of every high-pass branch.
        children[..., 1::2, :, :] = children[..., 1::2, ::-1, :]
        nodes = children.reshape(*signal.shape[:-1], -1, children.shape[-1])
    return nodes


class WaveletPacketOptions(ChannelOptions):
    """Options of `WaveletPacket`."""

    wavelet: transforms.WaveletName = "db8"
    """Name in PyWavelets."""

    level: Annotated[int, Field(strict=True, ge=1, le=10)] = 4
    """Level whose 2^level nodes are measured; up to level 5 the cost is small."""

    extension: transforms.Extension = "symmetric"
    """Extension of the record at its ends."""


class WaveletPacket(SingleChannelIndicator[WaveletPacketOptions]):
    """RMS of the coefficients of each node of a wavelet packet: bands of equal width."""

    name = "wavelet_packet"
    version = 1
    source = "Coifman and Wickerhauser, IEEE Trans. Inf. Theory 38(2) (1992) 713"
    equation = "n_k = sqrt(mean over i of w_k[i]²); node k covers k to k + 1 times f_s/2^(level+1)"
    Options = WaveletPacketOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """n0, n1, …, each with its band."""
        parts = 2 ** (self.options.level + 1)
        return tuple(
            Output(
                f"n{node}", self.unit, f"RMS of the packet from {node}/{parts} to {node + 1}/{parts} of f_s"
            )
            for node in range(parts // 2)
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the level."""
        return transforms.shortage(records.n_time, self.options.wavelet, self.options.level)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        options = self.options
        nodes = packet_coefficients(self.signal(records), options.wavelet, options.level, options.extension)
        rms = transforms.root_mean_square(nodes)
        return {output.name: rms[:, node] for node, output in enumerate(self.outputs)}


_CHAMBERS = {"chamber_1": Channel.CHAMBER_1_PRESSURE, "chamber_2": Channel.CHAMBER_2_PRESSURE}


class A4Options(Section):
    """Options of `A4`."""

    wavelet: transforms.WaveletName = "db8"
    """Name in PyWavelets."""

    level: transforms.Levels = 4
    """Level of the approximation, which contains frequencies below f_s/2^(level + 1)."""

    boundary: Literal["kept", "left_out"] = "kept"
    """Whether coefficients that depend on the symmetric extension of the record are used."""

    @property
    def transform(self) -> transforms.WaveletConfig:
        """The wavelet and its levels."""
        return transforms.WaveletConfig(name=self.wavelet, levels=self.level, boundary=self.boundary)


class A4(Indicator[A4Options]):
    """RMS of the level-4 approximation of each chamber pressure, which external leakage changes."""

    name = "a4"
    version = 1
    source = "Goharrizi and Sepehri, International Journal of Fluid Power (abstract); its RMS is a choice"
    equation = "a_4 = sqrt(mean over k of a_4[k]²) of P_1 and of P_2"
    Options = A4Options

    channels = frozenset(_CHAMBERS.values())

    @property
    def outputs(self) -> tuple[Output, ...]:
        """One output for each chamber."""
        level = self.options.level
        return tuple(
            Output(name, "Pa", f"RMS of the approximations of level {level} of {name.replace('_', ' ')}")
            for name in _CHAMBERS
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the level."""
        return transforms.shortage(records.n_time, self.options.wavelet, self.options.level)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the pressures, each (n_record,)."""
        wavelet = self.options.transform
        return {
            name: transforms.coefficient_rms(records[channel], wavelet).approximation[:, -1]
            for name, channel in _CHAMBERS.items()
        }
