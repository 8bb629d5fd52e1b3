"""Windows of equal duration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.window import Window
from hydrofdi.records.streams.windower import Windower


class TimeWindower(Windower):
    """Windows at equal distances: adjacent, overlapping, or apart.

    Parameters
    ----------
    n_sample : int
        Samples of a window.
    n_every : int
        Samples from the start of one window to the start of the next.
    channels : sequence of Channel
    sampling_frequency : float
        [Hz]
    """

    def __init__(
        self, n_sample: int, n_every: int, channels: Sequence[Channel], sampling_frequency: float
    ) -> None:
        super().__init__(n_sample, channels, sampling_frequency)
        self.n_every = n_every

    def start(self) -> State:
        """The state before the first sample."""
        return {"held": self._nothing_held(), "n_ahead": np.array(0), "number": np.array(0)}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""
        rows, number = self._rows(state, piece), int(state["number"])
        first = 0 if piece.begins_anew else int(state["n_ahead"])
        starts = range(first, rows.shape[1] - self.n_sample + 1, self.n_every)
        windows = list(self._windows(rows, [(start, start + self.n_sample) for start in starts], number))
        due = first + len(starts) * self.n_every
        held = {
            "held": rows[:, due:].copy() if due else rows,
            "n_ahead": np.array(max(0, due - rows.shape[1])),
            "number": np.array(number + len(windows)),
        }
        return held, windows
