"""The leakage indicator of the paper: percentage change of a coefficient's RMS."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def percentage_change(
    healthy_rms: NDArray[np.float64], faulty_rms: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Relative fall of the RMS from the healthy to the faulty state.

    Parameters
    ----------
    healthy_rms, faulty_rms : ndarray, shapes that broadcast
        RMS of the same coefficient in either state, in one unit.

    Returns
    -------
    ndarray
        δ [%], positive where the RMS fell. Equation (13).
    """
    change: NDArray[np.float64] = 100.0 * (healthy_rms - faulty_rms) / healthy_rms
    return change
