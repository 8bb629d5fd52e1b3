"""Checked samples of a stream → verdicts on its windows, or on its estimates."""

from __future__ import annotations

import math

import numpy as np

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.following import Follower
from hydrofdi.detectors.trained.judging import Judge
from hydrofdi.monitor.lines import WindowLine
from hydrofdi.records.streams import Chunk, State, Windower

PATIENCE = 10
"""Number of windows in a row, without overlap, after which a condition or an episode is over; seconds for
estimates."""

MOST_SAMPLES = 2**22
"""Most samples of windows that are judged at once; limits the memory."""


class ByWindows:
    """Judges windows of a stream without defects.

    Attributes
    ----------
    needs : tuple of Channel
        Channels that chunks must contain.
    patience : int
        Number of windows in a row after which a condition or an episode is over.
    """

    def __init__(self, file: DetectorFile) -> None:
        self._windower, self._judge = windower_of(file), Judge(file)
        self.needs = self._windower.needs
        n_every = file.config.window.n_every(file.n_sample, file.sampling_frequency)
        self.patience = PATIENCE * math.ceil(file.n_sample / n_every)
        n_window = max(1, MOST_SAMPLES // (file.n_sample * len(file.channels)))
        self._n_at_once = n_window * n_every

    def start(self) -> State:
        """The state before the first sample."""
        return self._windower.start()

    def step(self, state: State, piece: Chunk) -> tuple[State, list[WindowLine]]:
        """The state after a piece, and the windows that ended in it."""
        judged: list[WindowLine] = []
        for first in range(0, piece.n_time, self._n_at_once):
            state, windows = self._windower.step(state, piece.part(first, first + self._n_at_once))
            judged += [
                WindowLine(window.number, float(window.time[0]), float(window.time[-1]), verdict)
                for window, verdict in zip(windows, self._judge.judge(windows), strict=True)
            ]
        return state, judged


class ByEstimates:
    """Judges estimates of a recursive indicator, which are numbered consecutively; else as `ByWindows`."""

    def __init__(self, file: DetectorFile) -> None:
        self._follower, self.needs = Follower(file), file.channels
        self.patience = max(PATIENCE, round(PATIENCE * file.sampling_frequency / self._follower.n_every))

    def start(self) -> State:
        """The state before the first sample."""
        return {**self._follower.start(), "number": np.array(0)}

    def step(self, state: State, piece: Chunk) -> tuple[State, list[WindowLine]]:
        """The state after a piece, and its estimates."""
        number = int(state["number"])
        after, times, verdicts = self._follower.step(state, piece)
        judged = [
            WindowLine(number + count, float(time), float(time), verdict)
            for count, (time, verdict) in enumerate(zip(times, verdicts, strict=True))
        ]
        return {**after, "number": np.array(number + len(judged))}, judged


Judging = ByWindows | ByEstimates


def judging_of(file: DetectorFile) -> Judging:
    """Judging by windows or by estimates, as the detector was trained."""
    return ByEstimates(file) if file.config.window.by == "estimate" else ByWindows(file)


def windower_of(file: DetectorFile) -> Windower:
    """The windower that divides the stream as in training."""
    return file.config.window.windower(file.n_sample, file.channels, file.sampling_frequency, file.drive)
