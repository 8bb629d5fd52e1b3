"""Balances in weak form: integrals of signals against a smooth function over short windows.

With a test function φ that vanishes at both ends of a window, ∫ φ s' dt = −∫ φ' s dt, so that no measured
signal is differentiated. Shinbrot, On the analysis of linear and nonlinear dynamical systems from
transient-response data, NACA TN 3288 (1954).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


Kind = Literal["value", "rate", "late_rate"]


def weak_integrals(signal: Array, sampling_frequency: float, half: int, *kinds: Kind) -> Array:
    """Integrals over windows of 2 `half` sampling intervals, which begin every `half`: trapezoidal rule.

    Parameters
    ----------
    signal : ndarray, shape (n_record, n_time)
    sampling_frequency : float
        [Hz]
    half : int
        Half of a window, in sampling intervals.
    kinds : str
        ``value``: ∫ φ s dt. ``rate``: ∫ φ s' dt. ``late_rate``: ∫ φ τ s' dt. φ is sin² over the window, and τ
        the time from its middle.

    Returns
    -------
    ndarray, shape (n_kind, n_record, n_window)
        Two windows overlap by half; there are n_time // half − 1 of them.
    """
    n_block = signal.shape[1] // half
    blocks = np.ascontiguousarray(signal[:, : n_block * half]).reshape(-1, n_block, half)
    parts = blocks @ weak_weights(half, sampling_frequency, kinds)
    return np.moveaxis(parts[:, :-1, : len(kinds)] + parts[:, 1:, len(kinds) :], -1, 0)


@lru_cache(maxsize=64)
def weak_weights(half: int, sampling_frequency: float, kinds: tuple[Kind, ...]) -> Array:
    """Weights (half, 2 n_kind) of the samples in the first and in the second half of a window.

    φ' is scaled so that the sums are exact for a ramp: the tangent stands for its argument.
    """
    place = np.arange(2 * half)
    phase = np.pi * place / (2 * half)
    weight, slope = np.sin(phase) ** 2, np.sin(2.0 * phase) * np.tan(np.pi / (2 * half))
    kernels = {
        "value": weight / sampling_frequency,
        "rate": -slope,
        "late_rate": -(weight + slope * (place - half)) / sampling_frequency,
    }
    chosen = np.stack([kernels[kind] for kind in kinds], axis=1)
    return np.concatenate((chosen[:half], chosen[half:]), axis=1)
