"""Variational mode decomposition: narrow-band modes whose sum approximates the signal.

Dragomiretskiy and Zosso, IEEE Trans. Signal Process. 62(3) (2014) 531, without the Lagrange multiplier that
enforces exact reconstruction (noise slack). As in the paper, the record is mirrored at its ends; its spectrum
is then a real cosine transform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class VariationalModes:
    """Modes of a record, lowest frequency first.

    Attributes
    ----------
    rms : ndarray, shape (n_mode,)
        In the unit of the signal.
    frequency : ndarray, shape (n_mode,)
        Power-weighted mean frequency [cycles per sample].
    iterations : int
        Number of iterations until convergence; equal to the limit if it did not converge.
    """

    rms: Array
    frequency: Array
    iterations: int


def variational_modes(
    signal: Array, n_mode: int, bandwidth_weight: float, tolerance: float, most_iterations: int
) -> VariationalModes:
    """Modes of a record with its mean removed.

    Parameters
    ----------
    signal : ndarray, shape (n_time,)
        Finite values.
    n_mode : int
    bandwidth_weight : float
        Penalty α, for frequencies in cycles per sample.
    tolerance : float
        Convergence limit of the sum of squared relative changes of the modes.
    most_iterations : int
        Maximum number of iterations.
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
