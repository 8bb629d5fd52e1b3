"""Size and frequency of the variational modes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms.variational import variational_modes

_FEWEST_SAMPLES = 16
_STILL = 1e-12
"""RMS over the largest sample below which a mode stands still: rounding makes it."""


class VmdOptions(ChannelOptions):
    """Options of `Vmd`."""

    modes: Annotated[int, Field(strict=True, ge=1, le=12)] = 2
    """Number of modes, the slowest first; surplus modes share one of the record's oscillations."""

    bandwidth_weight: Annotated[float, SI("1", above=0)] = 2000.0
    """Weight α of the bandwidths, for frequencies in cycles per sample [-]; a large weight gives narrow
    modes."""

    tolerance: Annotated[float, SI("1", above=0)] = 1e-7
    """Iterations stop when the squared change of the modes over their squares falls below this [-]."""

    most_iterations: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 1000
    """Largest number of iterations."""


class Vmd(SingleChannelIndicator[VmdOptions]):
    """RMS and mean frequency of the variational modes of a record less its mean."""

    name = "vmd"
    version = 1
    summary = "RMS and mean frequency of narrow-band modes whose sum is the record."
    source = "Dragomiretskiy and Zosso, IEEE Trans. Signal Process. 62(3) (2014) 531"
    equation = "minimise α Σ bandwidth(u_k)² + |x − Σ u_k|²; rms_k = sqrt(mean of u_k²)"
    is_cheap = False
    Options = VmdOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """rms1, …, frequency1, …, and how many iterations it took."""
        modes = range(1, self.options.modes + 1)
        return (
            *(Output(f"rms{mode}", self.unit, f"RMS of mode {mode}") for mode in modes),
            *(Output(f"frequency{mode}", "Hz", f"mean frequency of mode {mode}") for mode in modes),
            Output.quality("iterations", "1", "iterations taken; at the limit the modes still change"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """A record of a few samples."""
        if records.n_time < _FEWEST_SAMPLES:
            return f"a record of {records.n_time} samples has no modes; {_FEWEST_SAMPLES} are needed"
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Record by record: each takes its own number of iterations. A mode of no size has no frequency."""
        numbers = np.array(
            [self._numbers(record, records.sampling_frequency) for record in self.signal(records)]
        )
        return {output.name: numbers[:, place] for place, output in enumerate(self.outputs)}

    def _numbers(self, record: Array, sampling_frequency: float) -> Array:
        options = self.options
        if not np.isfinite(record).all():
            return np.full(len(self.outputs), np.nan)
        found = variational_modes(
            record, options.modes, options.bandwidth_weight, options.tolerance, options.most_iterations
        )
        moves = found.rms > _STILL * np.abs(record).max()
        rms, frequency = np.where(moves, found.rms, 0.0), np.where(moves, found.frequency, np.nan)
        return np.concatenate([rms, frequency * sampling_frequency, [found.iterations]])
