"""Recursive estimate of the variance of white noise in a signal."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel

Array = NDArray[np.float64]

_ORDER = 8
"""Order of the differences. They attenuate frequencies below a tenth of the sampling frequency to less than a
tenth, and scale the variance of white noise by `_GAIN`."""

_GAIN = float(comb(2 * _ORDER, _ORDER))


def new_noise(n_record: int) -> Array:
    """Initial state of `follow_noise`: differences, consecutive clear samples, sum, number."""
    return np.zeros((n_record, _ORDER + 3))


@kernel
def follow_noise(signal: Array, unclear: NDArray[np.bool_], state: Array, variance: Array) -> None:
    """Fill the noise variance of a signal up to each sample, from high-order differences.

    Parameters
    ----------
    signal : ndarray, shape (n_record, n_time)
    unclear : ndarray of bool, shape (n_record, n_time)
        Samples to exclude, such as those of jumps.
    state : ndarray, shape (n_record, _ORDER + 3)
        From `new_noise`; updated in place.
    variance : ndarray, shape (n_record, n_time)
        Filled; 0 before the first difference.
    """
    for r in range(signal.shape[0]):
        own = state[r]
        for i in range(signal.shape[1]):
            left = signal[r, i]
            for k in range(_ORDER):
                difference = left - own[k]
                own[k] = left
                left = difference
            own[_ORDER] = 0.0 if unclear[r, i] else own[_ORDER] + 1.0
            if own[_ORDER] > _ORDER:
                own[_ORDER + 1] += left * left / _GAIN
                own[_ORDER + 2] += 1.0
            variance[r, i] = own[_ORDER + 1] / own[_ORDER + 2] if own[_ORDER + 2] > 0.0 else 0.0
