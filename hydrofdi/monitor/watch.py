"""Lines of a stream, by pure functions of samples and a state of arrays: verdicts, events, the condition."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.consequence import consequence
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.following import ChartReading, Follower, ScoreChart
from hydrofdi.detectors.trained.measuring import Judge, Verdict
from hydrofdi.monitor.lines import Condition, Line, WindowLine
from hydrofdi.records import Array
from hydrofdi.records.streams import Chunk, EvenStream, Event, EventKind, State, Windower
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import plain

PATIENCE = 10
"""Number of windows in a row, without overlap, after which a condition or an episode is over; seconds for
estimates."""

MOST_SAMPLES = 2**22
"""Most samples of windows that are judged at once; limits the memory."""


class ByWindows:
    """Judges windows of a stream without defects; `needs` are the channels that chunks must contain.

    `patience` is the number of windows in a row after which a condition or an episode is over.
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


MINUTE = 60.0
"""Interval at which continuing defects are summed up [s]."""

_WORDS = {
    EventKind.GAP: "gap",
    EventKind.RATE_CHANGED: "off-rate sample",
    EventKind.DUPLICATE: "duplicate sample",
    EventKind.TIME_RAN_BACK: "out-of-order sample",
    EventKind.MALFORMED: "unreadable sample",
}
_KINDS = list(_WORDS)


_KIND_OF_FAULT = {
    "other_rate": EventKind.RATE_CHANGED,
    "missing": EventKind.MISSING_SAMPLES,
    **{each: EventKind(each) for each in ("stuck", "clipped", "novel", "missing_channel")},
}
_BEYOND = "novel, the score beyond its limit"
_EPISODES = {
    **{kind.value.replace("_", " "): kind for kind in (*_KIND_OF_FAULT.values(), EventKind.NOT_JUDGED)},
    _BEYOND: EventKind.NOVEL,
}
"""Name of an episode → kind of its events; a score beyond its limit makes an episode of its own."""

_NAMES = list(_EPISODES)


_NO_EPISODES: State = {
    "count": np.zeros(len(_NAMES), dtype=np.int64),
    "quiet": np.zeros(len(_NAMES), dtype=np.int64),
    "span": np.full((len(_NAMES), 2), np.nan),
}


def _noted(state: State, found: Sequence[Event]) -> tuple[State, list[Event]]:
    """Defects after findings: the first of an episode is an event, the others wait for a minute to end."""
    waiting, events = state["waiting"].copy(), list[Event]()
    for event in found:
        waiting[_KINDS.index(event.kind)] += event.count - (not event.is_silent)
        events += [] if event.is_silent else [replace(event, count=1)]
    return {**state, "waiting": waiting}, events


def _begins_minute(state: State, pieces: Sequence[Chunk]) -> bool:
    """Whether pieces have a sample in another minute than the last sample before."""
    ends = (time for piece in pieces for time in (piece.time[0], piece.time[-1]))
    return any(time // MINUTE != state["minute"] for time in ends)


def _summed_up(state: State) -> tuple[State, list[Event]]:
    """Defects after a minute of the stream's clock, and an event for each kind that was only counted."""
    minute = float(state["minute"])
    end = MINUTE * (minute + 1.0) if math.isfinite(minute) else None
    until = "" if end is None else f" up to {end:.10g} s"
    events = [
        Event(kind, f"{counted(int(count), f'more {_WORDS[kind]}')}{until}", end, int(count))
        for kind, count in zip(_KINDS, state["waiting"], strict=True)
        if count
    ]
    return {**state, "waiting": np.zeros_like(state["waiting"])}, events


def _conditioned(
    state: State, patience: int, end: float, verdict: Verdict, chart: ChartReading | None
) -> tuple[State, Condition, list[Event]]:
    """The state after a window that ends at an instant [s], the condition, and the events.

    An alarm is raised at the first alarm of the chart, or of the threshold if there is no chart, and cleared
    after `patience` judged windows in a row without one. After as many windows that are not judged, the
    condition is unknown.
    """
    is_judged, is_raised = verdict.alarm is not None, bool(state["is_raised"])
    n_not_judged = 0 if is_judged else min(int(state["n_not_judged"]) + 1, patience)
    state, events = {**state, "n_not_judged": np.array(n_not_judged)}, list[Event]()
    if is_judged:
        is_alarm = verdict.alarm if chart is None else chart.alarm
        n_calm = 0 if is_alarm else min(int(state["n_calm"]) + 1, patience)
        state["n_calm"] = np.array(n_calm)
        state |= {"n_judged": state["n_judged"] + 1, "n_alarm": state["n_alarm"] + bool(is_alarm)}
        if is_alarm and not is_raised:
            state |= {"is_raised": np.array(1), "since": np.array(end)}
            doubt = f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
            events = [Event(EventKind.ALARM_RAISED, _why(verdict, chart) + doubt, end)]
        elif is_raised and n_calm >= patience:
            since = f"{float(state['since']):.10g} s"
            text = f"no alarm in {counted(n_calm, 'window')}; the alarm was raised at {since}"
            state["is_raised"] = np.array(0)
            events = [Event(EventKind.ALARM_CLEARED, text, end)]
    known = Condition.ALARM if state["is_raised"] else Condition.HEALTHY
    return state, Condition.UNKNOWN if n_not_judged >= patience else known, events


def _why(verdict: Verdict, chart: ChartReading | None) -> str:
    if chart is not None:
        statistic, limit = (plain(each, 4) for each in (chart.statistic or 0.0, chart.limit))
        return f"the statistic of the chart, {statistic}, reaches its limit, {limit}"
    return f"the score is {plain(-(verdict.margin or 0.0), 4)} healthy spreads beyond its limit"


def _episodes(
    state: State, patience: int, start: float, end: float, verdict: Verdict
) -> tuple[State, list[Event]]:
    """Faults of windows after one from `start` to `end` [s], and events: an episode of a kind of fault ends
    after `patience` windows without it."""
    if verdict.fault is None and not state["count"].any():
        return state, []
    count, span = state["count"].copy(), state["span"].copy()
    quiet = np.where(count > 0, state["quiet"] + 1, 0)
    events = []
    if verdict.fault is not None:
        kind = _KIND_OF_FAULT.get(verdict.fault.kind, EventKind.NOT_JUDGED)
        row = _NAMES.index(_BEYOND if verdict.is_beyond else kind.value.replace("_", " "))
        is_going_on = bool(count[row])
        span[row] = (span[row, 0] if is_going_on else start), end
        count[row], quiet[row] = count[row] + 1, 0
        text = f"from {start:.10g} s on, windows are not judged: {verdict.fault.message}"
        events.append(Event(kind, text, start, is_silent=is_going_on))
    for row in np.flatnonzero(quiet >= patience).tolist():
        events.append(_over(row, count, span))
        count[row], quiet[row] = 0, 0
    return {"count": count, "quiet": quiet, "span": span}, events


def _over(row: int, count: NDArray[np.int64], span: Array) -> Event:
    name, n, (start, end) = _NAMES[row], int(count[row]), span[row]
    text = f"over: {n} window{'s' * (n > 1)} not judged ({name}) from {start:.10g} s to {end:.10g} s"
    return Event(_EPISODES[name], text, float(end), n, is_end=True)


_Stepped = tuple[State, list[Chunk], list[Event]]


class Watch:
    """Turns samples into lines. The lines of a stream do not depend on its chunks."""

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        self._judging = judging_of(file)
        self._stream = EvenStream(file.sampling_frequency, self._judging.needs)
        self._chart = None if file.chart is None else ScoreChart(file)

    def start(self) -> State:
        """The state before the first sample."""
        own = {"is_raised": 0, "n_calm": 0, "n_not_judged": self._judging.patience, "since": np.nan}
        own |= {"n_judged": 0, "n_alarm": 0}
        return _flat(
            {
                "stream": self._stream.start(),
                "judging": self._judging.start(),
                "chart": {} if self._chart is None else self._chart.start(),
                "defects": {"waiting": np.zeros(len(_KINDS), dtype=np.int64), "minute": np.array(-np.inf)},
                "episodes": _NO_EPISODES,
                "conditions": {name: np.array(value) for name, value in own.items()},
            }
        )

    def resume(self, state: State, *, may_repeat: bool = True) -> State:
        """A stored state that continues: samples that are sent again are dropped without a report."""
        parts = _parts(state)
        return _flat({**parts, "stream": self._stream.resumed(parts["stream"], may_repeat=may_repeat)})

    def next_number(self, state: State) -> int:
        """Number of the next window."""
        return int(_parts(state)["judging"]["number"])

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Line]]:
        """The state after a chunk, and its lines; the old state does not change."""
        parts = _parts(state)
        stepped = self._stream.step(parts["stream"], chunk)
        if not stepped[2] and not parts["defects"]["waiting"].any():
            lines = self._follow(parts, stepped)
        else:
            lines = [line for some in self._alone(parts, chunk) for line in self._follow(parts, some)]
        return _flat(parts), lines

    def end(self, state: State) -> tuple[State, list[Line]]:
        """The lines at the end of a stream: counts that were not reported, and ends of episodes."""
        parts = _parts(state)
        parts["defects"], sums = _summed_up(parts["defects"])
        count, span = (parts["episodes"][name] for name in ("count", "span"))
        parts["episodes"] = _NO_EPISODES
        return _flat(parts), [*sums, *(_over(row, count, span) for row in np.flatnonzero(count).tolist())]

    def _alone(self, parts: Mapping[str, State], chunk: Chunk) -> Iterator[_Stepped]:
        """Steps of the stream. A sample that is news, or begins a minute, has a step of its own, so that the
        place of its lines does not depend on the chunk.
        """
        stepped = _, pieces, found = self._stream.step(parts["stream"], chunk)
        is_news = not all(event.is_silent for event in found)
        if chunk.n_time > 1 and (is_news or _begins_minute(parts["defects"], pieces)):
            half = chunk.n_time // 2
            yield from self._alone(parts, chunk.part(0, half))
            yield from self._alone(parts, chunk.part(half, chunk.n_time))
        else:
            yield stepped

    def _follow(self, parts: dict[str, State], stepped: _Stepped) -> list[Line]:
        """Lines of checked samples."""
        parts["stream"], pieces, found = stepped
        sums: list[Event] = []
        if _begins_minute(parts["defects"], pieces):
            parts["defects"], sums = _summed_up(parts["defects"])
        parts["defects"], events = _noted(parts["defects"], found)
        if pieces:
            parts["defects"] = {**parts["defects"], "minute": np.array(pieces[-1].time[-1] // MINUTE)}
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
        patience = self._judging.patience
        parts["episodes"], episodes = _episodes(parts["episodes"], patience, start, end, verdict)
        parts["conditions"], condition, alarms = _conditioned(
            parts["conditions"], patience, end, verdict, reading
        )
        alarms = [self._with_consequence(parts["conditions"], event, verdict) for event in alarms]
        return [replace(window, chart=reading, condition=condition), *episodes, *alarms]

    def _with_consequence(self, state: State, event: Event, verdict: Verdict) -> Event:
        """An alarm with what it comes to."""
        if event.kind is not EventKind.ALARM_RAISED:
            return event
        n_judged, n_alarm = int(state["n_judged"]), int(state["n_alarm"])
        found = consequence(self.file, n_judged, n_alarm, verdict.score, verdict.margin, verdict.doubt)
        return replace(event, text=f"{event.text}; {found.sentences}", details=found.to_dict())


def _flat(parts: Mapping[str, State]) -> State:
    return {f"{part}.{name}": array for part, state in parts.items() for name, array in state.items()}


def _parts(state: State) -> dict[str, State]:
    parts: dict[str, dict[str, Any]] = {"chart": {}}
    for key, array in state.items():
        part, _, name = key.partition(".")
        parts.setdefault(part, {})[name] = array
    return dict[str, State](parts)
