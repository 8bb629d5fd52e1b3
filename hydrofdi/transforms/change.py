"""The leakage indicator of the paper: percentage change of a coefficient's RMS."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def percentage_change(
    healthy_rms: NDArray[np.float64], faulty_rms: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Relative decrease of the RMS from the healthy to the faulty state.

    Parameters
    ----------
    healthy_rms, faulty_rms : ndarray, shapes that broadcast
        RMS of the same coefficient in each state, in the same unit.

    Returns
    -------
    ndarray
        δ [%], positive if the RMS decreased. Equation (13).
    """
    change: NDArray[np.float64] = 100.0 * (healthy_rms - faulty_rms) / healthy_rms
    return change
