"""The division of a stream into windows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence

import numpy as np

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.faults import fault_of
from hydrofdi.records.streams.window import Window


class Windower(ABC):
    """Cuts pieces into windows, which do not depend on the ends of pieces. Windows begin anew after a gap.

    Parameters
    ----------
    n_sample : int
        Samples of a window.
    channels : sequence of Channel
        Channels of the windows.
    sampling_frequency : float
        Expected [Hz].
    """

    def __init__(self, n_sample: int, channels: Sequence[Channel], sampling_frequency: float) -> None:
        self.n_sample = n_sample
        self.channels = tuple(channels)
        self.sampling_frequency = sampling_frequency

    @property
    def needs(self) -> tuple[Channel, ...]:
        """Channels that pieces need."""
        return self.channels

    @abstractmethod
    def start(self) -> State:
        """The state before the first sample."""

    @abstractmethod
    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""

    def _rows(self, state: State, piece: Chunk) -> Array:
        """The held samples followed by those of a piece; the rows are time and channels."""
        held = self._nothing_held() if piece.begins_anew else state["held"]
        n_held = held.shape[1]
        rows = np.empty((held.shape[0], n_held + piece.time.size))
        rows[:, :n_held] = held
        for row, samples in zip(
            rows, (piece.time, *map(piece.channels.__getitem__, self.channels)), strict=True
        ):
            row[n_held:] = samples
        return rows

    def _nothing_held(self) -> Array:
        return np.empty((1 + len(self.channels), 0))

    def _windows(self, rows: Array, spans: Sequence[tuple[int, int]], number: int) -> Iterator[Window]:
        """Windows with copies of their samples, numbered from `number` on."""
        for count, (first, stop) in enumerate(spans):
            time, *samples = own = rows[:, first:stop].copy()
            fault = fault_of(time, own[1:], self.channels, self.n_sample, self.sampling_frequency)
            yield Window(number + count, time, dict(zip(self.channels, samples, strict=True)), fault)
