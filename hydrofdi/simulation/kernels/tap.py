"""How signals are read at every step of the solver, while they are simulated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

SignalByName = Callable[[str], NDArray[np.float64]]
"""Gives a signal by its name in a trajectory: shape (n_step, n_lane); only the first lanes count."""

Reader = Callable[[int, SignalByName], None]
"""Reads a stretch of time, named by the number of its first step. Stretches follow without a gap."""


class Tap(Protocol):
    """What reads runs of a batch at every step; a record of all steps is never held."""

    def wants(self, position: int) -> bool:
        """Whether the run at a position of the batch is to be read."""

    def feedback_noise(self, position: int) -> NDArray[np.float64] | None:
        """Noise of the position that the controller of a run reads [m], at each of its samples, or None."""

    def reader(self, positions: Sequence[int]) -> Reader:
        """What reads the runs at these positions, side by side in the first lanes."""
