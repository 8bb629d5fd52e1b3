"""Pieces of a stream → verdicts on its windows, or on its estimates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hydrofdi.detectors.trained import DetectorFile, Verdict
from hydrofdi.detectors.trained.following import Follower
from hydrofdi.detectors.trained.judging import Judge
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.records import Channel
from hydrofdi.records.streams import Piece, State, Windower, make_windower

PATIENCE = 10
"""Number of windows in a row, without overlap, after which a condition or an episode is over; seconds for
estimates."""

MOST_SAMPLES = 2**22
"""Most samples of windows that are judged at once; limits the memory."""


@dataclass(frozen=True)
class Judged:
    """A window or an estimate: its number, its first and last instant [s], its verdict."""

    number: int
    start: float
    end: float
    verdict: Verdict


class Judging(Protocol):
    """The judging of a stream without defects.

    Attributes
    ----------
    needs : tuple of Channel
        Channels that pieces must contain.
    patience : int
        Number of windows in a row after which a condition or an episode is over.
    """

    needs: tuple[Channel, ...]
    patience: int

    def start(self) -> State:
        """The state before the first sample."""
        ...

    def step(self, state: State, piece: Piece) -> tuple[State, list[Judged]]:
        """The state after a piece, and the windows or estimates that ended in it."""
        ...


def judging_of(file: DetectorFile) -> Judging:
    """Judging by windows or by estimates, as the detector was trained."""
    return ByEstimates(file) if file.config.window.by == "estimate" else ByWindows(file)


class ByWindows:
    """Judges windows of a stream."""

    def __init__(self, file: DetectorFile) -> None:
        self._windower, self._judge = windower_of(file), Judge(file)
        self.needs = self._windower.needs
        n_every = samples_between(file)
        self.patience = PATIENCE * math.ceil(file.n_sample / n_every)
        n_window = max(1, MOST_SAMPLES // (file.n_sample * len(file.channels)))
        self._n_at_once = n_window * n_every

    def start(self) -> State:
        """The state before the first sample."""
        return self._windower.start()

    def step(self, state: State, piece: Piece) -> tuple[State, list[Judged]]:
        """The state after a piece, and the windows that ended in it."""
        judged: list[Judged] = []
        for some in _parts(piece, self._n_at_once):
            state, windows = self._windower.step(state, some)
            judged += [
                Judged(window.number, float(window.time[0]), float(window.time[-1]), verdict)
                for window, verdict in zip(windows, self._judge.judge(windows), strict=True)
            ]
        return state, judged


class ByEstimates:
    """Judges estimates of a recursive indicator, which are numbered consecutively."""

    def __init__(self, file: DetectorFile) -> None:
        self._follower, self.needs = Follower(file), file.channels
        indicator = Judge(file).indicator
        assert isinstance(indicator, RecursiveIndicator)
        n_sample = indicator.samples_per_estimate(file.sampling_frequency)
        self.patience = max(PATIENCE, round(PATIENCE * file.sampling_frequency / n_sample))

    def start(self) -> State:
        """The state before the first sample."""
        return {**self._follower.start(), "number": np.array(0)}

    def step(self, state: State, piece: Piece) -> tuple[State, list[Judged]]:
        """The state after a piece, and its estimates."""
        number = int(state["number"])
        after, times, verdicts = self._follower.step(state, piece)
        judged = [
            Judged(number + count, float(time), float(time), verdict)
            for count, (time, verdict) in enumerate(zip(times, verdicts, strict=True))
        ]
        return {**after, "number": np.array(number + len(judged))}, judged


def windower_of(file: DetectorFile) -> Windower:
    """The windower that divides the stream as in training."""
    window = file.config.window
    return make_windower(
        "cycle" if window.by == "cycle" else "time",
        file.n_sample,
        samples_between(file),
        channels=file.channels,
        sampling_frequency=file.sampling_frequency,
        drive_channel=window.channel,
        drive=file.drive,
        edge=window.edge,
    )


def samples_between(file: DetectorFile) -> int:
    """Samples from the start of one window to the start of the next; cycles do not overlap."""
    every = file.config.window.every
    if every is None or file.config.window.by == "cycle":
        return file.n_sample
    return max(1, round(every * file.sampling_frequency))


def _parts(piece: Piece, n_sample: int) -> Iterator[Piece]:
    """The same samples in pieces of at most `n_sample`."""
    for first in range(0, piece.time.size, n_sample):
        some = slice(first, first + n_sample)
        rows = {channel: row[some] for channel, row in piece.channels.items()}
        yield Piece(piece.time[some], rows, piece.begins_anew and first == 0)
