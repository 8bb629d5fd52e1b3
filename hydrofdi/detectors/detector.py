"""A trained detector: scores of windows, lines of a stream, and windows of records, judged and counted."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.detectors import lines as stream_lines
from hydrofdi.detectors import verdicts
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.promise import Consequence, consequence
from hydrofdi.detectors.rules import make_chart
from hydrofdi.errors import Issue
from hydrofdi.evaluation.rates import FEWEST_GROUPS, Rate, alarm_rate
from hydrofdi.evaluation.scores import comparable
from hydrofdi.records import RecordBatch
from hydrofdi.records.streams import Chunk, EvenStream, Event, EventKind, Joining, State, Window

NUMBER = "judging.number"
"""Key of the number of the next window in a state."""

PATIENCE = 10
"""Number of windows in a row, without overlap, after which a condition or an episode is over."""

MOST_SAMPLES = 2**22
"""Most samples of windows that are judged at once; limits the memory."""

_Stepped = tuple[State, list[Chunk], list[Event]]


class Detector:
    """Judges windows, and says what happens on a stream.

    The verdict on a window does not depend on other windows, nor the lines of a stream on its chunks.

    Attributes
    ----------
    file : DetectorFile
        Indicator, limits and what its promise rests on, in SI.
    """

    def __init__(self, file: DetectorFile) -> None:
        self.file = file
        frequency, channels, window = file.sampling_frequency, file.channels, file.config.window
        self._joining, self._stream = Joining(frequency, channels), EvenStream(frequency, channels)
        self._windower = window.windower(file.n_sample, channels, frequency, file.drive)
        self._patience = PATIENCE * math.ceil(file.n_sample / file.n_every)
        chart = file.config.chart
        self._chart = None if chart is None else make_chart(chart.chart, chart.options)

    def score(self, windows: Sequence[Window]) -> list[verdicts.Verdict]:
        """Judge windows by themselves.

        Parameters
        ----------
        windows : sequence of Window
            With all channels of the detector.

        Returns
        -------
        list of Verdict
            In order.
        """
        file, sound = self.file, [window for window in windows if window.fault is None]
        judged: Iterator[verdicts.Verdict] = iter(())
        if sound:
            records = verdicts.records_of(sound, file.channels, file.sampling_frequency)
            measured = verdicts.measured_windows(records, file.feature, file.fits)
            scores = file.scores(np.array([each.numbers for each in measured])).tolist()
            rows = zip(scores, measured, verdicts.findings(records, file.ranges), strict=True)
            judged = (verdicts.verdict_of(file, *row) for row in rows)
        return [verdicts.Verdict(fault=each.fault) if each.fault else next(judged) for each in windows]

    def start(self) -> State:
        """The state before the first sample of a stream: a mapping of arrays."""
        return _flat(
            {
                "joining": self._joining.start(),
                "stream": self._stream.start(),
                "judging": self._windower.start(),
                "chart": {} if self._chart is None else self._chart.start(1),
                "defects": stream_lines.NO_DEFECTS,
                "episodes": stream_lines.NO_EPISODES,
                "conditions": {**stream_lines.NOT_KNOWN, "n_not_judged": np.array(self._patience)},
            }
        )

    def resumed(self, state: State, *, may_repeat: bool = True) -> State:
        """A stored state that continues: samples that are sent again are dropped without a report."""
        parts = _parts(state)
        stream = self._stream.resumed(parts["stream"], may_repeat=may_repeat)
        joining = self._joining.start() if may_repeat else parts["joining"]
        return _flat({**parts, "joining": joining, "stream": stream})

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[stream_lines.Line]]:
        """Judge the next samples of a stream.

        Parameters
        ----------
        state : mapping of str to ndarray
            From `start`, or from the step before; it does not change.
        chunk : Chunk
            Samples of any number; they need not be evenly spaced.

        Returns
        -------
        state : mapping of str to ndarray
            For the next step.
        lines : list of WindowLine and Event
            A line for each window that ended, and for each event.
        """
        parts = _parts(state)
        parts["joining"], chunk = self._joining.step(parts["joining"], chunk)
        lines = self._checked(parts, chunk)
        return _flat(parts), lines

    def end(self, state: State) -> tuple[State, list[stream_lines.Line]]:
        """The lines at the end of a stream: counts that were not reported, and ends of episodes."""
        parts = _parts(state)
        parts["joining"], rest = self._joining.step(parts["joining"], Chunk(np.empty(0), {}), is_end=True)
        lines = self._checked(parts, rest)
        parts["defects"], sums = stream_lines.summed_up(parts["defects"])
        ends, parts["episodes"] = stream_lines.ended(parts["episodes"]), stream_lines.NO_EPISODES
        return _flat(parts), [*lines, *sums, *ends]

    def _checked(self, parts: dict[str, State], chunk: Chunk) -> list[stream_lines.Line]:
        """Lines of joined samples."""
        return [line for stepped in self._alone(parts, chunk) for line in self._follow(parts, stepped)]

    def _alone(self, parts: Mapping[str, State], chunk: Chunk) -> Iterator[_Stepped]:
        """Steps of the stream. A sample that is news, or begins a minute, has a step of its own, so that the
        place of its lines does not depend on the chunk.
        """
        stepped = _, pieces, events = self._stream.step(parts["stream"], chunk)
        is_news = not all(event.is_silent for event in events)
        if events or parts["defects"]["waiting"].any():
            is_news |= stream_lines.begins_minute(parts["defects"], pieces)
        if chunk.n_time > 1 and is_news:
            half = chunk.n_time // 2
            yield from self._alone(parts, chunk.part(0, half))
            yield from self._alone(parts, chunk.part(half, chunk.n_time))
        else:
            yield stepped

    def _follow(self, parts: dict[str, State], stepped: _Stepped) -> list[stream_lines.Line]:
        """Lines of checked samples."""
        parts["stream"], pieces, defects = stepped
        parts["defects"], events = stream_lines.noted(parts["defects"], pieces, defects)
        lines: list[stream_lines.Line] = [*events]
        for piece in pieces:
            parts["judging"], judged = self._windows(parts["judging"], piece)
            for window in judged:
                lines += self._lines(parts, window)
        return lines

    def _windows(self, state: State, piece: Chunk) -> tuple[State, list[stream_lines.WindowLine]]:
        """The state after a piece, and the windows that ended in it."""
        file, lines = self.file, list[stream_lines.WindowLine]()
        n_at_once = file.n_every * max(1, MOST_SAMPLES // (file.n_sample * len(file.channels)))
        for first in range(0, piece.n_time, n_at_once):
            state, windows = self._windower.step(state, piece.part(first, first + n_at_once))
            lines += [
                stream_lines.WindowLine(each.number, float(each.time[0]), float(each.time[-1]), verdict)
                for each, verdict in zip(windows, self.score(windows), strict=True)
            ]
        return state, lines

    def _lines(self, parts: dict[str, State], window: stream_lines.WindowLine) -> list[stream_lines.Line]:
        """The line of a window, and the events that it causes."""
        verdict = window.verdict
        parts["chart"], reading = self._reading(parts["chart"], verdict)
        window = replace(window, chart=reading)
        parts["episodes"], events = stream_lines.episodes_after(parts["episodes"], self._patience, window)
        parts["conditions"], condition, alarm = stream_lines.conditioned(
            parts["conditions"], self._patience, window
        )
        if alarm is not None and alarm.kind is EventKind.ALARM_RAISED:
            n_judged, n_alarm = (int(parts["conditions"][name]) for name in ("n_judged", "n_alarm"))
            outcome = consequence(self.file, n_judged, n_alarm, verdict.leak, verdict.margin)
            alarm = replace(alarm, text=f"{alarm.text}; {outcome.sentences}", details=outcome.to_dict())
        return [replace(window, condition=condition), *events, *filter(None, [alarm])]

    def _reading(
        self, state: State, verdict: verdicts.Verdict
    ) -> tuple[State, stream_lines.ChartReading | None]:
        """The chart after a window; one that is not judged does not change it."""
        if self._chart is None or self.file.chart is None:
            return state, None
        judged = math.nan if verdict.alarm is None or verdict.score is None else verdict.score
        score = verdicts.standardised(judged, self.file.healthy, self.file.config.direction)
        after, statistic = self._chart.step(state, score.reshape(1, 1), self.file.chart.limit)
        value = float(statistic[0, 0])
        is_alarm = value >= self.file.chart.limit
        return after, stream_lines.ChartReading(
            None if math.isnan(value) else value, self.file.chart.limit, is_alarm
        )


def _flat(parts: Mapping[str, State]) -> State:
    return {f"{part}.{name}": array for part, state in parts.items() for name, array in state.items()}


def _parts(state: State) -> dict[str, State]:
    parts: dict[str, dict[str, Any]] = {"chart": {}}
    for key, array in state.items():
        part, _, name = key.partition(".")
        parts.setdefault(part, {})[name] = array
    return dict[str, State](parts)


_RATE = 0.01
"""Share of the sampling frequency that a record may differ."""

_SAID_OF_WINDOWS = ("missing", "stuck", "gap")
"""Remarks on whole records that windows have as faults of their own."""


@dataclass(frozen=True)
class JudgedWindow(stream_lines.WindowLine):
    """A window of a record, as the line of a monitor which is given the record as a stream by itself; or a
    record without any window, with a negative number and the reason as its fault. ``label``: condition of the
    record, where it is known.
    """

    record_id: str = ""
    source: str = ""
    group: str = ""
    label: str = ""


def judged_windows(detector: Detector, batch: RecordBatch) -> Iterator[JudgedWindow]:
    """Every window of records."""
    for record in batch.rejected:
        rejection = Issue(record.remark.message, kind=record.remark.kind)
        yield _without(rejection, record_id=record.record_id, source=record.source, group=record.group)
    for row in range(batch.n_record):
        named: dict[str, Any] = {
            "record_id": batch.record_ids[row], "source": batch.sources[row], "group": batch.groups[row],
            "label": batch.labels[row] if batch.labels else "",
        }  # fmt: skip
        fault = _forbidden(detector.file, batch, row)
        lines = [] if fault else _lines(detector, batch, row)
        yield from (JudgedWindow(**vars(line), **named) for line in lines)
        if not lines:
            yield _without(fault or _without_windows(detector.file, batch), **named)


def _without(fault: Issue, **named: Any) -> JudgedWindow:
    """A record without any window."""
    return JudgedWindow(-1, math.nan, math.nan, verdicts.Verdict(fault=fault), **named)


def _lines(detector: Detector, records: RecordBatch, row: int) -> list[stream_lines.WindowLine]:
    samples = {channel: values[row] for channel, values in records.channels.items()}
    _, told = detector.step(detector.start(), Chunk(records.time, samples))
    lines = [line for line in told if isinstance(line, stream_lines.WindowLine)]
    for remark in records.remarks[row]:
        if remark.kind == "unended" and lines and lines[-1].end == records.time[-1]:
            doubt = "; ".join(filter(None, (lines[-1].verdict.doubt, remark.message)))
            lines[-1] = replace(lines[-1], verdict=replace(lines[-1].verdict, doubt=doubt))
    return lines


def _forbidden(file: DetectorFile, records: RecordBatch, row: int) -> Issue | None:
    """Why a record cannot be taken for a stream of the detector."""
    if missing := [channel for channel in file.channels if channel not in records.channels]:
        unused = [remark.message for remark in records.remarks[row] if remark.kind == "unused"]
        return Issue("; ".join([f"has no {' and no '.join(missing)}", *unused]), kind="missing_channel")
    if abs(records.sampling_frequency / file.sampling_frequency - 1.0) > _RATE:
        rates = f"{records.sampling_frequency:.4g} Hz instead of {file.sampling_frequency:.4g} Hz"
        return Issue(f"is sampled at {rates}", kind="other_rate")
    if obstacle := verdicts.without_scale(records, file.channels):
        return Issue(obstacle, kind="no_scale")
    for remark in records.remarks[row]:
        concerns = not remark.where or remark.where in file.channels
        if remark.is_unusable and concerns and remark.kind not in _SAID_OF_WINDOWS:
            return Issue(remark.message, kind=remark.kind)
    return None


def _without_windows(file: DetectorFile, records: RecordBatch) -> Issue:
    lasts, window = f"lasts {records.duration:.4g} s", file.config.window
    duration = f"{file.n_sample / file.sampling_frequency:.4g} s"
    if window.by == "cycle" and records.n_time >= file.n_sample:
        return Issue(f"has no cycle: no {window.edge} edge of {window.channel} in time", kind="no_cycle")
    return Issue(f"{lasts}, and a window {duration}", kind="short_record")


class Tally:
    """Windows on their way, counted.

    ``faults``: kind → windows, or records without any, that were not judged, ``n_beyond`` of them with a
    score beyond a limit all the same. ``n_doubtful`` judged ones, with the ``first_doubt``. ``unjudged``:
    source and record of those of which nothing was judged nor novel, which is a finding → the first reason.
    """

    def __init__(self, file: DetectorFile, windows: Iterable[JudgedWindow]) -> None:
        self.file, self._windows = file, windows
        self.faults: Counter[str] = Counter()
        self.n_beyond = self.n_doubtful = 0
        self.first_doubt = ""
        self.unjudged: dict[tuple[str, str], str] = {}
        self._records: set[tuple[str, str]] = set()
        self._judged: list[tuple[bool, str, str, int]] = []  # alarm, group, record and place in it
        self._alarming: list[verdicts.Leak] = []
        self._duration = file.n_sample / file.sampling_frequency
        self._every = min(file.n_every / file.sampling_frequency, self._duration)

    def __iter__(self) -> Iterator[JudgedWindow]:
        for window in self._windows:
            self._count(window)
            yield window

    def _count(self, window: JudgedWindow) -> None:
        record, verdict = (window.source, window.record_id), window.verdict
        if record not in self._records:
            self._records.add(record)
            self.unjudged[record] = verdict.fault.message if verdict.fault else ""
        if verdict.fault is not None:
            self.faults[verdict.fault.kind] += 1
            self.n_beyond += bool(verdict.is_beyond)
        if verdict.doubt:
            self.n_doubtful += 1
            self.first_doubt = self.first_doubt or verdict.doubt
        if verdict.fault is None or verdict.fault.kind == "novel":
            self.unjudged.pop(record, None)
        if window.alarm is not None:
            block = int(comparable(window.start / self._duration))
            self._judged.append((window.alarm, window.group, " ".join(record), block))
            if window.alarm and verdict.leak is not None:
                self._alarming.append(verdict.leak)

    @property
    def n_record(self) -> int:
        """Records, those among them that were rejected."""
        return len(self._records)

    @property
    def n_judged(self) -> int:
        """Windows that were judged."""
        return len(self._judged)

    @property
    def n_alarm(self) -> int:
        """Alarms."""
        return sum(window[0] for window in self._judged)

    @property
    def hours(self) -> float:
        """Time that was judged [h]: of overlapping windows, what each adds."""
        return self.n_judged * self._every / 3600.0

    @property
    def rests_on(self) -> str | None:
        """What the interval of the share takes as independent: ``groups`` or ``records``; ``windows`` that do
        not overlap if these are too few; None if nothing is judged.
        """
        if self.n_group >= FEWEST_GROUPS:
            return self.group_noun
        return "windows" if self.n_judged else None

    @property
    def n_group(self) -> int:
        """Groups of which something was judged; records if nobody stated groups."""
        return len({group or record for _, group, record, _ in self._judged})

    @property
    def group_noun(self) -> str:
        """What they are: ``groups`` or ``records``."""
        return "groups" if any(window[1] for window in self._judged) else "records"

    @property
    def consequence(self) -> Consequence:
        """What the alarms come to; the leak is their median."""
        leak = verdicts.Leak(*np.median(self._alarming, axis=0).tolist()) if self._alarming else None
        return consequence(self.file, self.n_judged, self.n_alarm, leak)

    @property
    def rate(self) -> Rate:
        """The share of judged windows that are alarms, with its interval."""
        groups: list[str] | None = [group or record for _, group, record, _ in self._judged]
        if self.rests_on == "windows":
            blocks = [f"{record} {block}" for _, _, record, block in self._judged]
            groups = blocks if self._every < self._duration else None
        alarms = [float(window[0]) for window in self._judged]
        return alarm_rate(alarms, groups=groups, confidence=self.file.config.confidence)
