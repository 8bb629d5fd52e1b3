"""Balance equations in weak form: integrals of signals times a test function over short windows.

With a test function φ that vanishes at both ends of a window, ∫ φ s' dt = −∫ φ' s dt, so no measured signal
needs to be differentiated. Shinbrot, On the analysis of linear and nonlinear dynamical systems from
transient-response data, NACA TN 3288 (1954).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def weak_weights(half: int, sampling_frequency: float) -> Array:
    """Trapezoidal-rule weights of the samples for integrals over windows of 2 `half` sampling intervals.

    φ' is scaled so that the sums are exact for a ramp: tan(π/(2 half)) replaces π/(2 half).

    Parameters
    ----------
    half : int
        Half the window length [sampling intervals]; adjacent windows overlap by half.
    sampling_frequency : float
        [Hz]

    Returns
    -------
    ndarray, shape (2, 3, half)
        Weights in the first and second half of a window, for ∫ φ s dt, ∫ φ s' dt and ∫ φ τ s' dt. φ is sin²
        over the window; τ is the time from its middle.
    """
    place = np.arange(2 * half)
    phase = np.pi * place / (2 * half)
    weight, slope = np.sin(phase) ** 2, np.sin(2.0 * phase) * np.tan(np.pi / (2 * half))
    late = (weight + slope * (place - half)) / sampling_frequency
    weights = np.stack((weight / sampling_frequency, -slope, -late))
    return np.ascontiguousarray(weights.reshape(3, 2, half).transpose(1, 0, 2))
