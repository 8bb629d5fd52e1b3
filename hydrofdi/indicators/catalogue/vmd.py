"""Amplitude and frequency of the variational modes (VMD)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, ModeIndicator
from hydrofdi.records import Array
from hydrofdi.settings.quantities import SI


@dataclass(frozen=True)
class VariationalModes:
    """Modes of a record, lowest frequency first: RMS, and mean frequency [cycles per sample].

    The number of iterations equals the limit if it did not converge.
    """

    rms: Array
    frequency: Array
    iterations: int


def variational_modes(
    signal: Array, n_mode: int, bandwidth_weight: float, tolerance: float, most_iterations: int
) -> VariationalModes:
    """Modes of a record of finite values (n_time,) with its mean removed.

    `bandwidth_weight` is the penalty α, for frequencies in cycles per sample; `tolerance` the limit of the
    sum of squared relative changes of the modes.
    """
    from scipy.fft import dct

    # A cosine transform mirrors the record at its ends, so that they do not jump as in a Fourier transform.
    spectrum = dct(signal - signal.mean(), norm="ortho")
    spectrum[0] = 0.0
    frequency = np.arange(signal.size) / (2.0 * signal.size)
    modes, power = np.zeros((n_mode, signal.size)), np.zeros(n_mode)
    centres, total = 0.5 * np.arange(n_mode) / n_mode, np.zeros(signal.size)
    iteration, change = 0, np.inf
    while change > tolerance and iteration < most_iterations:
        iteration, change = iteration + 1, 0.0
        for number, mode in enumerate(modes):
            total -= mode
            # Wiener filter about the centre, of what the other modes leave.
            updated = (spectrum - total) / (1.0 + bandwidth_weight * np.square(frequency - centres[number]))
            total += updated
            change += _relative(float(np.sum(np.square(updated - mode))), power[number])
            mode[:] = updated
            squares = np.square(updated)
            power[number] = np.sum(squares)
            if power[number] > 0.0:
                centres[number] = np.sum(frequency * squares) / power[number]
    order = np.argsort(centres, kind="stable")
    return VariationalModes(np.sqrt(power / signal.size)[order], centres[order], iteration)


def _relative(change: float, power: float) -> float:
    if change == 0.0:
        return 0.0
    return change / power if power > 0.0 else np.inf


_ROUNDING = 1e-12
"""RMS relative to the largest sample below which a mode is only rounding error."""


class VmdOptions(ChannelOptions):
    """Options of `Vmd`."""

    modes: Annotated[int, Field(strict=True, ge=1, le=12)] = 2
    """Number of modes, lowest frequency first; surplus modes split an oscillation of the record."""

    bandwidth_weight: Annotated[float, SI("1", above=0)] = 2000.0
    """Weight α of the bandwidths, for frequencies in cycles per sample [-]; a large weight gives narrow
    modes."""

    tolerance: Annotated[float, SI("1", above=0)] = 1e-7
    """Iterations stop when the sum of squared relative changes of the modes falls below this [-]."""

    most_iterations: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 1000
    """Maximum number of iterations."""


class Vmd(ModeIndicator[VmdOptions]):
    """RMS and mean frequency of narrow-band modes whose sum approximates the record."""

    name = "vmd"
    version = 1
    source = "Dragomiretskiy and Zosso, IEEE Trans. Signal Process. 62(3) (2014) 531"
    equation = "minimise α Σ bandwidth(u_k)² + |x − Σ u_k|²; rms_k = sqrt(mean of u_k²)"
    Options = VmdOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """rms1, …, frequency1, …, and the number of iterations."""
        modes = range(1, self.options.modes + 1)
        return (
            *(Output(f"rms{mode}", self.unit, f"RMS of mode {mode}") for mode in modes),
            *(Output(f"frequency{mode}", "Hz", f"mean frequency of mode {mode}") for mode in modes),
            Output.quality("iterations", "1", "number of iterations; not converged if it equals the limit"),
        )

    def numbers_of(self, record: Array, sampling_frequency: float) -> Array:
        """The frequency of a mode with zero amplitude is NaN."""
        options = self.options
        found = variational_modes(
            record, options.modes, options.bandwidth_weight, options.tolerance, options.most_iterations
        )
        moves = found.rms > _ROUNDING * np.abs(record).max()
        rms, frequency = np.where(moves, found.rms, 0.0), np.where(moves, found.frequency, np.nan)
        return np.concatenate([rms, frequency * sampling_frequency, [found.iterations]])
