"""RMS of the coefficients of the discrete wavelet transform, as in the paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.phases import phase_rms
from hydrofdi.transforms.wavelet import coefficient_rms, n_phase, shortage


class DwtOptions(WaveletConfig):
    """Options of `Dwt`."""

    channel: Channel = Channel.CHAMBER_1_PRESSURE
    """Channel to transform."""


class Dwt(Indicator[DwtOptions]):
    """RMS of details d1, d2, … and approximations a1, a2, … of a decimated transform."""

    name = "dwt"
    version = 1
    summary = "RMS of the detail and approximation coefficients of the discrete wavelet transform."
    source = (
        "Maddahi et al. (2015, the paper that hydrofdi reproduces); Goharrizi and Sepehri, IEEE Trans. Ind."
        " Electron. (2010)"
    )
    equation = "d_j = sqrt(mean over k of d_j[k]²), a_j alike; level j covers f_s/2^(j+1) to f_s/2^j"
    Options = DwtOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """The transformed channel."""
        return frozenset({self.options.channel})

    @property
    def outputs(self) -> tuple[Output, ...]:
        """d1 …, a1 …, and the details at each start phase if all phases are measured."""
        unit, levels = self.options.channel.unit, range(1, self.options.levels + 1)
        outputs = [
            Output(f"d{level}", unit, f"RMS of the details of level {level}", direction=_fall(level))
            for level in levels
        ]
        outputs += [
            Output(f"a{level}", unit, f"RMS of the approximations of level {level}") for level in levels
        ]
        if self.options.phase == "all":
            phases = {"phase": n_phase(self.options.levels)}
            outputs += [
                replace(
                    output,
                    name=f"{output.name}_phases",
                    long_name=f"{output.long_name} at each phase",
                    dims=phases,
                )
                for output in outputs[: self.options.levels]
            ]
        return tuple(outputs)

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the levels."""
        n_sample = records.n_time - self.options.latest_start
        return shortage(n_sample, self.options.name, self.options.levels)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,); over phases (n_record, n_phase)."""
        wavelet, signal = self.options, records[self.options.channel]
        rms = coefficient_rms(signal[:, wavelet.first_sample :], wavelet)
        values = {f"d{level + 1}": rms.detail[:, level] for level in range(wavelet.levels)}
        values |= {f"a{level + 1}": rms.approximation[:, level] for level in range(wavelet.levels)}
        if wavelet.phase == "all":
            details = phase_rms(signal, wavelet)
            values |= {f"d{level + 1}_phases": details[..., level] for level in range(wavelet.levels)}
        return values


def _fall(level: int) -> Direction | None:
    """The paper's rule: leakage damps the hydraulic mode, which lies in the band of d2 or d3."""
    return Direction.FALLING if level in (2, 3) else None
