"""Verdicts on streams from the estimates of a recursive indicator, without windows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrofdi.detectors.trained.estimating import Estimator
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.judging import verdict_of
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.detectors.trained.novelty import findings
from hydrofdi.detectors.trained.verdict import Verdict
from hydrofdi.errors import Issue
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.records.streams import Chunk, State
from hydrofdi.records.streams.faults import fault_of

_HELD = "held"

_LEAST_CHECKED_TIME = 1.0
"""Minimum time before an estimate whose samples are checked [s]."""

_BATCH_SIZE = 64
"""Number of estimates that are judged at a time."""


class Follower:
    """Judges the estimates of a stream with a trained detector, if the preceding samples are valid.

    Parameters
    ----------
    file : DetectorFile
        Detector with ``window.by: estimate``.

    Raises
    ------
    ConfigError
        The indicator cannot be made or is not recursive.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        feature, frequency = feature_of(file.config), file.sampling_frequency
        self._estimator = Estimator(feature, file.channels, frequency, file.fits)
        self._n_look = samples_looked_at(self._estimator.indicator, file.sampling_frequency)

    def start(self) -> State:
        """The state before the first sample: arrays alone."""
        return {_HELD: np.empty((1 + len(self.file.channels), 0)), **self._estimator.start()}

    def step(self, state: State, piece: Chunk) -> tuple[State, Array, list[Verdict]]:
        """State after a piece, the instants of its estimates [s], and a verdict on each."""
        after, found = self._estimator.step(state, piece)
        new = np.stack([piece.time, *(piece.channels[channel] for channel in self.file.channels)])
        rows = new if piece.begins_anew else np.concatenate([state[_HELD], new], axis=1)
        n_held = rows.shape[1] - new.shape[1]
        verdicts: list[Verdict] = []
        for first in range(0, len(found), _BATCH_SIZE):
            some = found[first : first + _BATCH_SIZE]
            faults = self._faults(rows, [n_held + each.place + 1 for each in some])
            verdicts += [
                verdict_of(self.file, each.score, each.fault or fault, doubts=each.doubts)
                for each, fault in zip(some, faults, strict=True)
            ]
        times = np.array([each.time for each in found])
        return {**after, _HELD: rows[:, -self._n_look :].copy()}, times, verdicts

    def _faults(self, rows: Array, stops: Sequence[int]) -> list[Issue | None]:
        """Fault of the samples before each of some places; None if there are too few samples to check."""
        channels, frequency = self.file.channels, self.file.sampling_frequency
        looks = [rows[:, max(0, stop - self._n_look) : stop] for stop in stops]
        faults: list[Issue | None] = [None] * len(looks)
        whole = [place for place, look in enumerate(looks) if look.shape[1] == self._n_look]
        for place in whole:
            time, samples = looks[place][0], looks[place][1:]
            faults[place] = fault_of(time, samples, channels, self._n_look, frequency)
        sound = [place for place in whole if faults[place] is None]
        if sound:
            samples = np.stack([looks[place][1:] for place in sound], axis=1)
            names = tuple(map(str, sound))
            records = RecordBatch(dict(zip(channels, samples, strict=True)), frequency, names)
            for place, fault in zip(sound, findings(records, self.file.ranges), strict=True):
                faults[place] = fault
        return faults


def samples_looked_at(indicator: RecursiveIndicator[Any], sampling_frequency: float) -> int:
    """Number of samples before an estimate that are checked: a transient, but at least one second."""
    seconds: float = max(indicator.options.transient, _LEAST_CHECKED_TIME)
    return max(2, round(seconds * sampling_frequency))
