"""Seeded pseudo-random levels, each held for a period."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.sections.drive import RecordConfig


def random_levels(
    seed: int | Sequence[int], period: float, record: RecordConfig, steps: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Levels at the given steps.

    Parameters
    ----------
    seed : int or sequence of int
    period : float
        Holding time of a level, a multiple of the step [s].
    record : RecordConfig
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        Levels, uniformly distributed in −1 … 1 [-].
    """
    hold = round(period / record.step)
    levels = np.random.default_rng(seed).uniform(-1.0, 1.0, -(-record.n_step // hold))
    return levels[steps // hold]
