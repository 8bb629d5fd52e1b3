"""Lines of a stream: pure, with a state of arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hydrofdi.detectors.trained import ChartReading, DetectorFile
from hydrofdi.detectors.trained.charting import chart_of
from hydrofdi.monitor.conditions import Conditions
from hydrofdi.monitor.defects import Defects, part
from hydrofdi.monitor.episodes import Episodes
from hydrofdi.monitor.judged import Judged, judging_of
from hydrofdi.monitor.lines import Line, WindowLine
from hydrofdi.records.streams import Chunk, EvenStream, Finding, Piece, State

_Stepped = tuple[State, list[Piece], list[Finding]]


class Watch:
    """Samples go in, lines come out. The lines of a stream do not depend on its chunks.

    Parameters
    ----------
    file : DetectorFile

    Raises
    ------
    ConfigError
        Its indicator or chart cannot be made.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        self._judging = judging_of(file)
        self._stream = EvenStream(file.sampling_frequency, self._judging.needs)
        self._chart = chart_of(file)
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
        """A stored state, fit to go on: samples that come again are left out in silence.

        Parameters
        ----------
        state : State
        may_repeat : bool
            Whether all of the stream may come again. If not, a clock that was set back meanwhile is found.
        """
        parts = _parts(state)
        return _flat({**parts, "stream": self._stream.resumed(parts["stream"], may_repeat=may_repeat)})

    def next_number(self, state: State) -> int:
        """Number of the next window."""
        return int(_parts(state)["judging"]["number"])

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Line]]:
        """The state behind a chunk, and what is to be said of it; the old state stays as it was."""
        parts, lines = _parts(state), list[Line]()
        stepped = self._stream.step(parts["stream"], chunk)
        if stepped[2] or self._defects.has_waiting(parts["defects"]):
            for begins_minute, minute in self._defects.minutes(parts["defects"], chunk):
                if begins_minute:
                    parts["defects"], events = self._defects.sum_up(parts["defects"])
                    lines += events
                for some in self._alone(parts["stream"], minute):
                    lines += self._follow(parts, some)
                parts["defects"] = self._defects.passed(parts["defects"], minute)
        else:
            lines += self._follow(parts, stepped)
            parts["defects"] = self._defects.passed(parts["defects"], chunk)
        return _flat(parts), lines

    def end(self, state: State) -> tuple[State, list[Line]]:
        """What is to be said when a stream is over: what was counted, and what ends with it."""
        parts = _parts(state)
        parts["defects"], sums = self._defects.sum_up(parts["defects"])
        parts["episodes"], over = self._episodes.end(parts["episodes"])
        return _flat(parts), [*sums, *over]

    def _alone(self, state: State, chunk: Chunk) -> Iterator[_Stepped]:
        """Steps of the stream; a sample that is news is alone in its own, so that its place is known."""
        stepped = self._stream.step(state, chunk)
        if chunk.n_time == 1 or not any(finding.is_news for finding in stepped[2]):
            yield stepped
            return
        half = chunk.n_time // 2
        for some in (part(chunk, 0, half), part(chunk, half, chunk.n_time)):
            for stepped in self._alone(state, some):
                state = stepped[0]
                yield stepped

    def _follow(self, parts: dict[str, State], stepped: _Stepped) -> list[Line]:
        """Lines of samples that are checked."""
        parts["stream"], pieces, findings = stepped
        parts["defects"], events = self._defects.step(parts["defects"], findings)
        lines: list[Line] = [*events]
        for piece in pieces:
            parts["judging"], judged = self._judging.step(parts["judging"], piece)
            for window in judged:
                lines += self._lines(parts, window)
        return lines

    def _lines(self, parts: dict[str, State], window: Judged) -> list[Line]:
        """The line of a window, and what it changes."""
        start, end, verdict = window.start, window.end, window.verdict
        reading: ChartReading | None = None
        if self._chart is not None:
            parts["chart"], reading = self._chart.step(parts["chart"], verdict)
        parts["episodes"], episodes = self._episodes.step(parts["episodes"], start, end, verdict)
        parts["conditions"], condition, alarms = self._conditions.step(
            parts["conditions"], end, verdict, reading
        )
        line = WindowLine(window.number, start, end, verdict, reading, condition)
        return [line, *episodes, *alarms]


def _flat(parts: Mapping[str, State]) -> State:
    return {f"{part}.{name}": array for part, state in parts.items() for name, array in state.items()}


def _parts(state: State) -> dict[str, State]:
    parts: dict[str, dict[str, Any]] = {"chart": {}}
    for key, array in state.items():
        part, _, name = key.partition(".")
        parts.setdefault(part, {})[name] = array
    return dict[str, State](parts)
