"""Control charts on the time series of a score.

The input of a chart are standardised scores (median 0 and spread 1 if healthy); it does not depend on their
interval or on the indicator. It raises an alarm when its statistic reaches the limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.registry import Method
from hydrofdi.evaluation.scores import Array, Direction
from hydrofdi.settings.quantities import Section

State = Mapping[str, NDArray[Any]]
"""State of a chart between chunks: arrays, so that it can be stored."""

LARGEST = 1e9
"""Standardised scores are limited to ± this value; infinite scores too."""


class ChartOptions(Section):
    """Options of every chart."""

    direction: Direction = Direction.BOTH
    """Direction in which the score raises an alarm: ``rising``, ``falling`` or ``both``."""


Chosen = TypeVar("Chosen", bound=ChartOptions)


class Chart(Method[Chosen]):
    """Interface of a chart: a statistic of all scores so far; x in its equation is the standardised score.

    Attributes
    ----------
    kernel : callable
        Takes scores and statistic, shape (n_stream, n_time), memory, shape (n_stream, n_memory), the limit,
        whether it is two-sided, and `arguments`. It fills the statistic and updates the memory. A NaN score
        leaves the memory unchanged and gives NaN; the memory is reset to zero when the limit is reached.
    """

    kernel: ClassVar[Callable[..., None]]

    @property
    def n_memory(self) -> int:
        """Number of memory values per stream; all are zero at the start."""
        return 2

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Further arguments of the kernel."""
        return ()

    def start(self, n_stream: int) -> State:
        """State before the first score."""
        return {"memory": np.zeros((n_stream, self.n_memory))}

    def step(self, state: State, scores: ArrayLike, limit: float = math.inf) -> tuple[State, Array]:
        """State after a chunk, and its statistic; the old state is not modified.

        The statistic of a stream is bit-identical however it is split into chunks. NaN scores are skipped:
        their statistic is NaN, which raises no alarm.

        Parameters
        ----------
        state : mapping of str to ndarray
        scores : array_like, shape (n_stream, n_time)
            Standardised [-].
        limit : float
            The chart restarts when the statistic reaches it.

        Returns
        -------
        state : mapping of str to ndarray
        statistic : ndarray, shape (n_stream, n_time)
            Alarm if statistic >= limit.
        """
        direction = self.options.direction
        sign = -1.0 if direction is Direction.FALLING else 1.0
        held = np.ascontiguousarray(np.clip(sign * np.asarray(scores, dtype=float), -LARGEST, LARGEST))
        memory = np.array(state["memory"], dtype=float, order="C")
        if held.ndim != 2 or held.shape[0] != memory.shape[0]:
            raise ValueError(f"expected scores of {memory.shape[0]} streams in the shape (n_stream, n_time)")
        statistic = np.empty_like(held)
        self.kernel(held, statistic, memory, float(limit), direction is Direction.BOTH, *self.arguments)
        return {"memory": memory}, statistic

    def follow(self, scores: ArrayLike, limit: float = math.inf) -> Array:
        """Statistic of whole streams, shape (n_stream, n_time)."""
        values = np.asarray(scores, dtype=float)
        return self.step(self.start(values.shape[0]), values, limit)[1]
