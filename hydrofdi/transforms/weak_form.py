"""Balances in weak form: integrals of signals against a smooth function over short windows.

With a test function φ that vanishes at both ends of a window, ∫ φ s' dt = −∫ φ' s dt, so that no measured
signal is differentiated. Shinbrot, On the analysis of linear and nonlinear dynamical systems from
transient-response data, NACA TN 3288 (1954).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def weak_integrals(signal: Array, sampling_frequency: float, half: int) -> Array:
    """Integrals over windows of 2 `half` sampling intervals, which begin every `half`: trapezoidal rule.

    Parameters
    ----------
    signal : ndarray, shape (n_record, n_time)
    sampling_frequency : float
        [Hz]
    half : int
        Half of a window, in sampling intervals.

    Returns
    -------
    ndarray, shape (3, n_record, n_window)
        ∫ φ s dt, ∫ φ s' dt and ∫ φ τ s' dt, with φ = sin² over the window and τ the time from its middle.
        Two windows overlap by half; there are n_time // half − 1 of them.
    """
    n_block = signal.shape[1] // half
    blocks = np.ascontiguousarray(signal[:, : n_block * half]).reshape(-1, n_block, half)
    parts = blocks @ _kernels(half)
    sums = parts[:, :-1, :3] + parts[:, 1:, 3:]
    intervals = np.array([1.0 / sampling_frequency, 1.0, 1.0 / sampling_frequency])
    return np.moveaxis(sums * intervals, -1, 0)


@lru_cache(maxsize=16)
def _kernels(half: int) -> Array:
    """Weights (half, 6) of the samples in the first and in the second half of a window.

    φ' is scaled so that the sums are exact for a ramp: the tangent stands for its argument.
    """
    place = np.arange(2 * half)
    phase = np.pi * place / (2 * half)
    weight, slope = np.sin(phase) ** 2, np.sin(2.0 * phase) * np.tan(np.pi / (2 * half))
    kernels = np.stack((weight, -slope, -(weight + slope * (place - half))), axis=1)
    return np.concatenate((kernels[:half], kernels[half:]), axis=1)
