"""Control charts on the time series of a score.

The input of a chart are standardised scores (median 0 and spread 1 if healthy); it does not depend on their
interval or on the indicator. It raises an alarm when its statistic reaches the limit.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

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


class Chart(Protocol[Chosen]):
    """Interface of a chart: a statistic of all scores so far.

    Subclasses define `n_memory` and `advance`.

    Attributes
    ----------
    name : str
        Name in files and on the command line.
    summary : str
        What it computes, in one sentence.
    source : str
        Publication.
    equation : str
        Its definition, in one line; x is the standardised score.
    caution : str
        Limitations that users must know.
    Options : type of ChartOptions
        Model of its options; all of them have defaults.
    options : ChartOptions
        Options of this instance.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str]
    equation: ClassVar[str]
    caution: ClassVar[str]
    Options: ClassVar[type[ChartOptions]] = ChartOptions
    options: Chosen

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen

    @property
    @abstractmethod
    def n_memory(self) -> int:
        """Number of memory values per stream; all are zero at the start."""

    @abstractmethod
    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Fill the statistic and update the memory, for rising scores or for both directions.

        A NaN score leaves the memory unchanged and gives NaN. The memory is reset to zero when the limit is
        reached.

        Parameters
        ----------
        scores, statistic : ndarray, shape (n_stream, n_time)
        memory : ndarray, shape (n_stream, n_memory)
        limit : float
        is_two_sided : bool
        """

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
        self.advance(held, memory, statistic, float(limit), direction is Direction.BOTH)
        return {"memory": memory}, statistic

    def follow(self, scores: ArrayLike, limit: float = math.inf) -> Array:
        """Statistic of whole streams, shape (n_stream, n_time)."""
        values = np.asarray(scores, dtype=float)
        return self.step(self.start(values.shape[0]), values, limit)[1]
