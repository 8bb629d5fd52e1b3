"""Modes of each record: empirical ones (emd) and variational ones (vmd)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.indicators.contract import ChannelOptions, ChosenChannel, Output, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms import root_mean_square

_FEWEST_SAMPLES = 16
"""Least number of samples of a record."""


class ModeIndicator(SingleChannelIndicator[ChosenChannel]):
    """An indicator of the modes of each record; `numbers_of` has the order of its outputs."""

    is_cheap = False

    def numbers_of(self, record: Array, sampling_frequency: float) -> Sequence[float] | Array:
        """Values of one record (n_time,) of finite samples."""
        raise NotImplementedError

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if records are too short to have modes."""
        if records.n_time < _FEWEST_SAMPLES:
            return f"a record of {records.n_time} samples has no modes; {_FEWEST_SAMPLES} are needed"
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); NaN if a sample is not finite."""
        numbers = np.full((records.n_record, len(self.outputs)), np.nan)
        for row, record in zip(numbers, self.signal(records), strict=True):
            if np.isfinite(record).all():
                row[:] = self.numbers_of(record, records.sampling_frequency)
        return {output.name: numbers[:, index] for index, output in enumerate(self.outputs)}


_MIRRORED = 3
"""Number of maxima, and of minima, mirrored at each end."""

Places = NDArray[np.intp]


def empirical_modes(signal: Array, n_mode: int, n_sifting: int) -> Array:
    """The first empirical modes (n_mode, n_time) of a record of finite values (n_time,).

    Each of `n_sifting` steps subtracts the mean of the envelopes. A mode is zero if the residual of the
    earlier modes does not oscillate.
    """
    modes, rest = np.zeros((n_mode, signal.size)), signal
    for mode in modes:
        mode[:] = _sifted(rest, n_sifting)
        rest = rest - mode
    return modes


def _sifted(signal: Array, n_sifting: int) -> Array:
    mode = signal
    for sifting in range(n_sifting):
        mean = _mean_of_envelopes(mode)
        if mean is None:
            return mode if sifting else np.zeros_like(signal)
        mode = mode - mean
    return mode


def _mean_of_envelopes(signal: Array) -> Array | None:
    """Mean of the splines through the maxima and the minima; None if there are fewer than two of either."""
    from scipy.interpolate import CubicSpline
    from scipy.signal import find_peaks

    maxima, minima = find_peaks(signal)[0], find_peaks(-signal)[0]
    if min(maxima.size, minima.size) < 2:
        return None
    # The end of a record is the start of the reversed one.
    last, instants = signal.size - 1, np.arange(signal.size)
    # Extrema are mirrored at both ends, or the splines would swing there.
    starts, first = _before_start(signal, maxima, minima)
    ends, turned = _before_start(signal[::-1], last - maxima[::-1], last - minima[::-1])
    envelopes = []
    for before, inner, after in zip(
        starts, (maxima, minima), (last - end[::-1] for end in ends), strict=True
    ):
        places = np.concatenate([2 * first - before, inner, 2 * (last - turned) - after])
        heights = signal[np.concatenate([before, inner, after])]
        envelopes.append(CubicSpline(places, heights)(instants))
    mean: Array = 0.5 * (envelopes[0] + envelopes[1])
    return mean


def _before_start(signal: Array, maxima: Places, minima: Places) -> tuple[tuple[Places, Places], int]:
    """Maxima and minima mirrored at the start of a record, farthest first, and the place of the mirror.

    The mirror is at the first extremum. It is at the first sample, which then counts as an extremum, if that
    sample lies beyond the next extremum or if the mirror image would not reach it.
    """
    rises = maxima[0] < minima[0]
    first, other = (maxima, minima) if rises else (minima, maxima)
    mirror, near, far = int(first[0]), first[1 : _MIRRORED + 1], other[:_MIRRORED]
    lies_beyond = signal[0] <= signal[other[0]] if rises else signal[0] >= signal[other[0]]
    if lies_beyond or 2 * mirror > min(near[-1], far[-1]):
        mirror, near, far = 0, first[:_MIRRORED], np.append(0, other[: _MIRRORED - 1])
    near, far = near[::-1], far[::-1]
    return ((near, far) if rises else (far, near)), mirror


class EmdOptions(ChannelOptions):
    """Options of `Emd`."""

    modes: Annotated[int, Field(strict=True, ge=1, le=10)] = 3
    """Number of modes, highest frequency first."""

    siftings: Annotated[int, Field(strict=True, ge=1, le=100)] = 10
    """Number of sifting steps per mode; there is no other stopping rule."""


class Emd(ModeIndicator[EmdOptions]):
    """RMS of the instantaneous amplitude of the first empirical modes, highest frequency first."""

    name = "emd"
    version = 1
    source = "Goharrizi and Sepehri, IEEE Trans. Instrum. Meas. 61(2) (2012) 368"
    equation = "imf_k = sqrt(mean over t of |c_k + i H c_k|²), c_k: mode after a fixed number of siftings"
    Options = EmdOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """imf1, imf2, …; zero if a record has no such mode."""
        return tuple(
            Output(f"imf{mode}", self.unit, f"RMS of the instantaneous amplitude of mode {mode}")
            for mode in range(1, self.options.modes + 1)
        )

    def numbers_of(self, record: Array, sampling_frequency: float) -> Array:
        """RMS in the unit of the channel."""
        from scipy.signal import hilbert

        modes = empirical_modes(record, self.options.modes, self.options.siftings)
        return root_mean_square(np.abs(hilbert(modes)))


def variational_modes(
    signal: Array, n_mode: int, bandwidth_weight: float, tolerance: float, most_iterations: int
) -> tuple[Array, Array, int]:
    """Modes of a record of finite values (n_time,) with its mean removed, lowest frequency first.

    RMS, mean frequency [cycles per sample], and the number of iterations, which equals the limit if it did
    not converge.

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
    return np.sqrt(power / signal.size)[order], centres[order], iteration


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
        rms, frequency, iterations = variational_modes(
            record, options.modes, options.bandwidth_weight, options.tolerance, options.most_iterations
        )
        moves = rms > _ROUNDING * np.abs(record).max()
        rms, frequency = np.where(moves, rms, 0.0), np.where(moves, frequency, np.nan)
        return np.concatenate([rms, frequency * sampling_frequency, [iterations]])
