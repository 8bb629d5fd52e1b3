"""Interface for reading signals at every step of the solver during simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

SignalByName = Callable[[str], NDArray[np.float64]]
"""Function from the name of a signal to its values, shape (n_step, n_lane); only the first lanes are used."""

Reader = Callable[[int, SignalByName], None]
"""Function that reads a block of steps, given the number of its first step; blocks are contiguous."""


class Tap(Protocol):
    """Interface that reads runs of a batch at every step; a record of all steps is never stored."""

    def wants(self, position: int) -> bool:
        """Whether to read the run at a position of the batch."""

    def feedback_noise(self, position: int) -> NDArray[np.float64] | None:
        """Noise of the position that the controller of a run reads, at each of its samples [m], or None."""

    def reader(self, positions: Sequence[int]) -> Reader:
        """Reader of the runs at these positions, which are in the first lanes."""
