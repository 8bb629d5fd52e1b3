"""Instantaneous amplitude of the first intrinsic mode functions (EMD)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.sifting import empirical_modes
from hydrofdi.transforms.wavelet import root_mean_square

_FEWEST_SAMPLES = 16


class EmdOptions(ChannelOptions):
    """Options of `Emd`."""

    modes: Annotated[int, Field(strict=True, ge=1, le=10)] = 3
    """Number of modes, highest frequency first."""

    siftings: Annotated[int, Field(strict=True, ge=1, le=100)] = 10
    """Number of sifting steps per mode; there is no other stopping rule."""


class Emd(SingleChannelIndicator[EmdOptions]):
    """RMS of the instantaneous amplitude of the first empirical modes."""

    name = "emd"
    version = 1
    summary = "RMS of the instantaneous amplitude of the first empirical modes, highest frequency first."
    source = "Goharrizi and Sepehri, IEEE Trans. Instrum. Meas. 61(2) (2012) 368"
    equation = "imf_k = sqrt(mean over t of |c_k + i H c_k|²), c_k: mode after a fixed number of siftings"
    is_cheap = False
    Options = EmdOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """imf1, imf2, …; zero if a record has no such mode."""
        return tuple(
            Output(f"imf{mode}", self.unit, f"RMS of the instantaneous amplitude of mode {mode}")
            for mode in range(1, self.options.modes + 1)
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record has too few samples."""
        if records.n_time < _FEWEST_SAMPLES:
            return f"a record of {records.n_time} samples has no modes; {_FEWEST_SAMPLES} are needed"
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        amplitudes = np.array([self._amplitudes(record) for record in self.signal(records)])
        return {f"imf{mode + 1}": amplitudes[:, mode] for mode in range(self.options.modes)}

    def _amplitudes(self, record: Array) -> Array:
        from scipy.signal import hilbert

        if not np.isfinite(record).all():
            return np.full(self.options.modes, np.nan)
        modes = empirical_modes(record, self.options.modes, self.options.siftings)
        return root_mean_square(np.abs(hilbert(modes)))
