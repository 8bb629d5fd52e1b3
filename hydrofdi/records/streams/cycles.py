"""Windows that begin with the cycles of the drive."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.window import Window
from hydrofdi.records.streams.windower import Windower
from hydrofdi.records.stuck import Direction, drive_edges


class CycleWindower(Windower):
    """A window from each edge of the drive on; the rest of a longer cycle is ignored.

    A shorter cycle ends at the next edge and becomes a window with the fault ``short_cycle``.

    Parameters
    ----------
    n_sample : int
        Samples of a window.
    channels : sequence of Channel
    sampling_frequency : float
        [Hz]
    drive_channel : Channel
        Pieces contain it; windows contain it if it is among `channels`.
    drive : (float, float)
        Lowest and highest value of the drive.
    edge : str
        ``rising``, ``falling`` or ``both``.
    """

    def __init__(
        self,
        n_sample: int,
        channels: Sequence[Channel],
        sampling_frequency: float,
        drive_channel: Channel,
        drive: tuple[float, float],
        edge: Direction = "rising",
    ) -> None:
        super().__init__(n_sample, channels, sampling_frequency)
        self.drive_channel, self.drive, self.edge = drive_channel, drive, edge

    @property
    def needs(self) -> tuple[Channel, ...]:
        """Channels that pieces need."""
        return tuple(dict.fromkeys((*self.channels, self.drive_channel)))

    def start(self) -> State:
        """The state before the first sample."""
        none = np.array(0)
        return {"held": self._nothing_held(), "is_open": np.array(False), "side": none, "number": none}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""
        side, is_open = (0, False) if piece.begins_anew else (int(state["side"]), bool(state["is_open"]))
        rows, number = self._rows(state, piece), int(state["number"])
        n_held = rows.shape[1] - piece.time.size
        places, side = drive_edges(piece.channels[self.drive_channel], self.drive, self.edge, side)
        firsts = ([0] if is_open else []) + [n_held + int(place) for place in places]
        spans = [
            (first, min(first + self.n_sample, following))
            for first, following in pairwise([*firsts, rows.shape[1]])
        ]
        is_open = bool(spans) and spans[-1][1] - spans[-1][0] < self.n_sample
        held = rows[:, spans.pop()[0] :].copy() if is_open else self._nothing_held()
        windows = list(self._windows(rows, spans, number))
        counts = {"is_open": is_open, "side": side, "number": number + len(windows)}
        return {"held": held, **{name: np.array(count) for name, count in counts.items()}}, windows
