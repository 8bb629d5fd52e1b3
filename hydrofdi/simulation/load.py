"""Load force over time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.sections.drive import RecordConfig
from hydrofdi.config.sections.machine import LoadConfig
from hydrofdi.simulation.random_levels import random_levels

_STREAM = 1
"""Random stream of the load, independent of an input with the same seed."""


def load_force(load: LoadConfig, record: RecordConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Force against positive motion, held over the given steps.

    Parameters
    ----------
    load : LoadConfig
    record : RecordConfig
        Its step divides the period of a pseudo-random force.
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        F_L [N].
    """
    if not load.random_force:
        return np.full(steps.shape, load.constant_force)
    levels = random_levels((load.seed, _STREAM), load.random_period, record, steps)
    return load.constant_force + load.random_force * levels
