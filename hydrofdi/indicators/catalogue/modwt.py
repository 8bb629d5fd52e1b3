"""RMS of the coefficients of the undecimated wavelet transform."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.wavelet import (
    Levels,
    WaveletConfig,
    WaveletName,
    boundary_length,
    inner_undecimated_rms,
    undecimated_rms,
)


class ModwtOptions(ChannelOptions):
    """Options of `Modwt`."""

    wavelet: WaveletName = "db8"
    """Name in PyWavelets."""

    levels: Levels = 5
    """Number of levels; d1 is the finest detail."""

    boundary: Literal["left_out", "circle"] = "left_out"
    """``left_out``: only coefficients that depend solely on samples of the record are used. ``circle``: the
    record is extended periodically, which suits an integer number of periods of a settled motion; if its ends
    do not match, the jump dominates the fine details."""

    @property
    def transform(self) -> WaveletConfig:
        """The wavelet and its levels."""
        return WaveletConfig(name=self.wavelet, levels=self.levels)


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
        options, longest = self.options, boundary_length(self.options.transform) + 1
        if records.n_time < longest:
            return (
                f"{options.levels} levels of {options.wavelet} need {longest} samples, not {records.n_time}"
            )
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        measure = undecimated_rms if self.options.boundary == "circle" else inner_undecimated_rms
        rms = measure(self.signal(records), self.options.transform)
        levels = range(self.options.levels)
        return {f"d{level + 1}": rms.detail[:, level] for level in levels} | {
            f"a{level + 1}": rms.approximation[:, level] for level in levels
        }
