"""Variational mode decomposition: modes that are narrow in frequency and together give the signal.

Dragomiretskiy and Zosso, IEEE Trans. Signal Process. 62(3) (2014) 531, without the multiplier that enforces
an exact sum (noise slack). The record is mirrored at its ends as there, so that its spectrum is a real cosine
transform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class VariationalModes:
    """Modes of a record, the slowest first.

    Attributes
    ----------
    rms : ndarray, shape (n_mode,)
        In the unit of the signal.
    frequency : ndarray, shape (n_mode,)
        Mean frequency, weighted by power [cycles per sample].
    iterations : int
        Taken until no mode changed any more; at the limit they still do.
    """

    rms: Array
    frequency: Array
    iterations: int


def variational_modes(
    signal: Array, n_mode: int, bandwidth_weight: float, tolerance: float, most_iterations: int
) -> VariationalModes:
    """Modes of a record less its mean.

    Parameters
    ----------
    signal : ndarray, shape (n_time,)
        Finite.
    n_mode : int
    bandwidth_weight : float
        α for frequencies in cycles per sample.
    tolerance : float
        Iterations end where the squared change of the modes, each over its square, is below.
    most_iterations : int
        They end here in any case.
    """
    from scipy.fft import dct

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
