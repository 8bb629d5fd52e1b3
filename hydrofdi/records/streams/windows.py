"""The division of streams into windows, by time or by cycles of the drive, and faults that samples show."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.checks import Chunk, EvenStream, State, Window
from hydrofdi.records.stuck import Direction, drive_edges, frozen_time, must_change
from hydrofdi.settings.counting import counted

_RATE = 0.01
"""Share of the sampling frequency by which the mean rate of a window may differ."""


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
        self.needs = self.channels = tuple(channels)
        self.sampling_frequency = sampling_frequency

    @abstractmethod
    def start(self) -> State:
        """The state before the first sample."""

    @abstractmethod
    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""

    def _rows(self, state: State, piece: Chunk) -> Array:
        """The held samples followed by those of a piece; the rows are time and channels."""
        held = self._nothing_held() if piece.begins_anew else state["held"]
        new = [piece.time, *(piece.channels[channel] for channel in self.channels)]
        rows = np.empty((len(held), held.shape[1] + piece.n_time))
        rows[:, : held.shape[1]] = held
        for row, samples in zip(rows, new, strict=True):
            row[held.shape[1] :] = samples
        return rows

    def _nothing_held(self) -> Array:
        return np.empty((1 + len(self.channels), 0))

    def _windows(self, rows: Array, spans: Sequence[tuple[int, int]], number: int) -> Iterator[Window]:
        """Windows with copies of their samples, numbered from `number` on."""
        for count, (first, stop) in enumerate(spans):
            time, *samples = own = rows[:, first:stop].copy()
            fault = fault_of(time, own[1:], self.channels, self.n_sample, self.sampling_frequency)
            yield Window(number + count, time, dict(zip(self.channels, samples, strict=True)), fault)


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
        self.needs = tuple(dict.fromkeys((*self.channels, drive_channel)))
        self.drive_channel, self.drive, self.edge = drive_channel, drive, edge

    def start(self) -> State:
        """The state before the first sample."""
        none = np.array(0)
        return {"held": self._nothing_held(), "is_open": np.array(False), "side": none, "number": none}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[Window]]:
        """The state after a piece, and the windows that ended in it; the old state does not change."""
        side, is_open = (0, False) if piece.begins_anew else (int(state["side"]), bool(state["is_open"]))
        rows, number = self._rows(state, piece), int(state["number"])
        n_held = rows.shape[1] - piece.n_time
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


def make_windower(
    by: Literal["time", "cycle"],
    n_sample: int,
    n_every: int | None = None,
    *,
    channels: Sequence[Channel],
    sampling_frequency: float,
    drive_channel: Channel = Channel.INPUT_VOLTAGE,
    drive: tuple[float, float] | None = None,
    edge: Direction = "rising",
) -> Windower:
    """The windower of a stream, by time or by cycle; the parameters are those of the classes.

    Raises
    ------
    ValueError
        A number of samples is below 1, or cycles have no range of the drive.
    """
    every = n_sample if n_every is None else n_every
    if min(n_sample, every) < 1:
        raise ValueError("windows need at least one sample, and at least one sample from start to start")
    if by == "time":
        return TimeWindower(n_sample, every, channels, sampling_frequency)
    if drive is None or not drive[1] > drive[0]:
        raise ValueError("cycles need the range of the drive")
    return CycleWindower(n_sample, channels, sampling_frequency, drive_channel, drive, edge)


def windows_of(time: Array, channels: Mapping[Channel, Array], windower: Windower) -> list[Window]:
    """Windows of a whole record in SI, over its instants [s]: those of a stream of its samples."""
    stream = EvenStream(windower.sampling_frequency, windower.needs)
    _, pieces, _ = stream.step(stream.start(), Chunk(time, channels))
    state, windows = windower.start(), list[Window]()
    for piece in pieces:
        state, ended = windower.step(state, piece)
        windows += ended
    return windows


def fault_of(
    time: Array, samples: Array, channels: tuple[Channel, ...], n_sample: int, sampling_frequency: float
) -> Issue | None:
    """The first fault of a window, in the order: length, rate, missing samples, stuck channels.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        [s]
    samples : ndarray, shape (n_channel, n_time)
        In SI.
    channels : tuple of Channel, length n_channel
    n_sample : int
        Samples that a window should have.
    sampling_frequency : float
        Expected [Hz].
    """
    n_time = time.size
    if n_time < n_sample:
        return Issue(f"the cycle has {counted(n_time, 'sample')} instead of {n_sample}", kind="short_cycle")
    rate = (n_time - 1) / float(time[-1] - time[0]) if n_time > 1 else sampling_frequency
    if abs(rate - sampling_frequency) > _RATE * sampling_frequency:
        text = f"samples come at {rate:.4g} Hz instead of {sampling_frequency:.4g} Hz"
        return Issue(text, kind="other_rate")
    lows, highs = samples.min(axis=1), samples.max(axis=1)
    for row in np.flatnonzero(~(np.isfinite(lows) & np.isfinite(highs))):
        n_missing = int(np.count_nonzero(~np.isfinite(samples[row])))
        if n_missing == n_time:
            return Issue(f"{channels[row]} is missing", kind="missing_channel")
        text = f"{n_missing} of {counted(n_time, 'sample')} of {channels[row]} are missing or not finite"
        return Issue(text, kind="missing")
    for row in np.flatnonzero(lows == highs):
        if must_change(channels[row]):
            return Issue(f"{channels[row]} never changes", kind="stuck")
    if frozen := frozen_time(dict(zip(channels, samples, strict=True)), sampling_frequency):
        text = f"{Channel.PISTON_POSITION} does not change for {frozen:.3g} s while the pressures do"
        return Issue(text, kind="stuck")
    return None
