"""What a chart is."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section

State = Mapping[str, NDArray[Any]]
"""All that a chart needs from one chunk to the next: arrays, so that it can be stored."""

LARGEST = 1e9
"""Standardised scores beyond ± this, infinite ones among them, are held there."""


class ChartOptions(Section):
    """Options of every chart."""

    direction: Direction = Direction.BOTH
    """Direction in which the score raises an alarm: ``rising``, ``falling`` or ``both``."""


Chosen = TypeVar("Chosen", bound=ChartOptions)


class Chart(Protocol[Chosen]):
    """A statistic of all scores so far. Subclass it; define how many numbers it keeps and how it advances.

    Attributes
    ----------
    name : str
        Name in files and on the command line; that of its module.
    summary : str
        What it asks of the scores, in one sentence.
    source : str
        Where it was published.
    equation : str
        Its definition, in one line; x is the standardised score.
    caution : str
        What breaks it, or has to be known before its alarms are believed.
    Options : type of ChartOptions
        Model of its options; it is valid without any.
    options : ChartOptions
        Its options.
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
        """Numbers that it keeps of each stream; all of them are zero at the start."""

    @abstractmethod
    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Fill the statistic and carry the memory on; rising scores, or both directions.

        A NaN leaves the memory as it is and gives NaN. Memory is set to zero if the limit is reached.

        Parameters
        ----------
        scores, statistic : ndarray, shape (n_stream, n_time)
        memory : ndarray, shape (n_stream, n_memory)
        limit : float
        is_two_sided : bool
        """

    def start(self, n_stream: int) -> State:
        """The state before the first score."""
        return {"memory": np.zeros((n_stream, self.n_memory))}

    def step(self, state: State, scores: ArrayLike, limit: float = math.inf) -> tuple[State, Array]:
        """The state behind a chunk, and the statistic that came with it; the old state stays as it was.

        Whatever the chunks, the statistic of a stream is the same to the bit. Scores that are NaN are passed
        over: their statistic is NaN, which raises no alarm.

        Parameters
        ----------
        state : mapping of str to ndarray
        scores : array_like, shape (n_stream, n_time)
            Standardised [-].
        limit : float
            The chart restarts after a statistic that reaches it.

        Returns
        -------
        state : mapping of str to ndarray
        statistic : ndarray, shape (n_stream, n_time)
            Larger is more alarming; an alarm where statistic >= limit.
        """
        direction = self.options.direction
        sign = -1.0 if direction is Direction.FALLING else 1.0
        held = np.ascontiguousarray(np.clip(sign * np.asarray(scores, dtype=float), -LARGEST, LARGEST))
        memory = np.array(state["memory"], dtype=float, order="C")
        if held.ndim != 2 or held.shape[0] != memory.shape[0]:
            raise ValueError(f"scores of {memory.shape[0]} streams have the shape (n_stream, n_time)")
        statistic = np.empty_like(held)
        self.advance(held, memory, statistic, float(limit), direction is Direction.BOTH)
        return {"memory": memory}, statistic

    def follow(self, scores: ArrayLike, limit: float = math.inf) -> Array:
        """The statistic along whole streams, shape (n_stream, n_time)."""
        values = np.asarray(scores, dtype=float)
        return self.step(self.start(values.shape[0]), values, limit)[1]
