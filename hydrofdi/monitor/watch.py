"""Lines of a stream, by pure functions of samples and a state of arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.following import ChartReading, Follower, ScoreChart
from hydrofdi.detectors.trained.measuring import Judge
from hydrofdi.monitor.conditions import Conditions, Defects, Episodes
from hydrofdi.monitor.lines import Event, Line, WindowLine
from hydrofdi.records.streams import Chunk, EvenStream, Finding, State, Windower

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


_Stepped = tuple[State, list[Chunk], list[Finding]]


class Watch:
    """Turns samples into lines. The lines of a stream do not depend on its chunks.

    Parameters
    ----------
    file : DetectorFile

    Raises
    ------
    ConfigError
        The indicator or the chart is invalid.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        self._judging = judging_of(file)
        self._stream = EvenStream(file.sampling_frequency, self._judging.needs)
        self._chart = None if file.chart is None else ScoreChart(file)
        self._defects = Defects()
        self._episodes = Episodes(self._judging.patience)
        self._conditions = Conditions(self._judging.patience)

    def start(self) -> State:
        """The state before the first sample."""
        return _flat(
            {
                "stream": self._stream.start(),
                "judging": self._judging.start(),
                "chart": {} if self._chart is None else self._chart.start(),
                "defects": self._defects.start(),
                "episodes": self._episodes.start(),
                "conditions": self._conditions.start(),
            }
        )

    def resume(self, state: State, *, may_repeat: bool = True) -> State:
        """A stored state that continues: samples that are sent again are dropped without a report.

        Parameters
        ----------
        state : State
        may_repeat : bool
            Whether the whole stream may be sent again. If not, a clock that was set back is detected.
        """
        parts = _parts(state)
        return _flat({**parts, "stream": self._stream.resumed(parts["stream"], may_repeat=may_repeat)})

    def next_number(self, state: State) -> int:
        """Number of the next window."""
        return int(_parts(state)["judging"]["number"])

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Line]]:
        """The state after a chunk, and its lines; the old state does not change."""
        parts = _parts(state)
        stepped = self._stream.step(parts["stream"], chunk)
        if not stepped[2] and not self._defects.has_waiting(parts["defects"]):
            lines = self._follow(parts, stepped)
        else:
            lines = [line for some in self._alone(parts, chunk) for line in self._follow(parts, some)]
        return _flat(parts), lines

    def end(self, state: State) -> tuple[State, list[Line]]:
        """The lines at the end of a stream: counts that were not reported, and ends of episodes."""
        parts = _parts(state)
        parts["defects"], sums = self._defects.sum_up(parts["defects"])
        parts["episodes"], over = self._episodes.end(parts["episodes"])
        return _flat(parts), [*sums, *over]

    def _alone(self, parts: Mapping[str, State], chunk: Chunk) -> Iterator[_Stepped]:
        """Steps of the stream. A sample that is news, or begins a minute, has a step of its own, so that the
        place of its lines does not depend on the chunk.
        """
        stepped = _, pieces, findings = self._stream.step(parts["stream"], chunk)
        is_news = any(finding.is_news for finding in findings)
        if chunk.n_time > 1 and (is_news or self._defects.begins_minute(parts["defects"], pieces)):
            half = chunk.n_time // 2
            yield from self._alone(parts, chunk.part(0, half))
            yield from self._alone(parts, chunk.part(half, chunk.n_time))
        else:
            yield stepped

    def _follow(self, parts: dict[str, State], stepped: _Stepped) -> list[Line]:
        """Lines of checked samples."""
        parts["stream"], pieces, findings = stepped
        sums: list[Event] = []
        if self._defects.begins_minute(parts["defects"], pieces):
            parts["defects"], sums = self._defects.sum_up(parts["defects"])
        parts["defects"], events = self._defects.step(parts["defects"], findings)
        parts["defects"] = self._defects.passed(parts["defects"], pieces)
        lines: list[Line] = [*sums, *events]
        for piece in pieces:
            parts["judging"], judged = self._judging.step(parts["judging"], piece)
            for window in judged:
                lines += self._lines(parts, window)
        return lines

    def _lines(self, parts: dict[str, State], window: WindowLine) -> list[Line]:
        """The line of a window, and the events that it causes."""
        start, end, verdict = window.start, window.end, window.verdict
        reading: ChartReading | None = None
        if self._chart is not None:
            parts["chart"], reading = self._chart.step(parts["chart"], verdict)
        parts["episodes"], episodes = self._episodes.step(parts["episodes"], start, end, verdict)
        parts["conditions"], condition, alarms = self._conditions.step(
            parts["conditions"], end, verdict, reading
        )
        return [replace(window, chart=reading, condition=condition), *episodes, *alarms]


def _flat(parts: Mapping[str, State]) -> State:
    return {f"{part}.{name}": array for part, state in parts.items() for name, array in state.items()}


def _parts(state: State) -> dict[str, State]:
    parts: dict[str, dict[str, Any]] = {"chart": {}}
    for key, array in state.items():
        part, _, name = key.partition(".")
        parts.setdefault(part, {})[name] = array
    return dict[str, State](parts)
