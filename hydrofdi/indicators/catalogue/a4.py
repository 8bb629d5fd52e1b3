"""RMS of an approximation of each chamber pressure: an indicator of external leakage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import Section
from hydrofdi.transforms.wavelet import Levels, WaveletConfig, WaveletName, coefficient_rms, shortage

_CHAMBERS = {"chamber_1": Channel.CHAMBER_1_PRESSURE, "chamber_2": Channel.CHAMBER_2_PRESSURE}


class A4Options(Section):
    """Options of `A4`."""

    wavelet: WaveletName = "db8"
    """Name in PyWavelets."""

    level: Levels = 4
    """Level of the approximation, which contains frequencies below f_s/2^(level + 1)."""

    boundary: Literal["kept", "left_out"] = "kept"
    """Whether coefficients that depend on the symmetric extension of the record are used."""

    @property
    def transform(self) -> WaveletConfig:
        """The wavelet and its levels."""
        return WaveletConfig(name=self.wavelet, levels=self.level, boundary=self.boundary)


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
        return shortage(records.n_time, self.options.wavelet, self.options.level)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the pressures, each (n_record,)."""
        wavelet = self.options.transform
        return {
            name: coefficient_rms(records[channel], wavelet).approximation[:, -1]
            for name, channel in _CHAMBERS.items()
        }
