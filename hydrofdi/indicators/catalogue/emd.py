"""Instantaneous amplitude of the first intrinsic mode functions (EMD)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, ModeIndicator
from hydrofdi.records import Array
from hydrofdi.transforms.wavelet import root_mean_square

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
