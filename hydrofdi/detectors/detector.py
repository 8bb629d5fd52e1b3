"""A detector: fitted to healthy records, it scores windows, and steps through the samples of a stream."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import Any, Self

import numpy as np

from hydrofdi.detectors import lines as stream_lines
from hydrofdi.detectors import verdicts
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.file import DetectorFile, Made
from hydrofdi.detectors.lines import ChartReading, Line, WindowLine
from hydrofdi.detectors.promise import consequence
from hydrofdi.detectors.rules import OF_ONE, make_chart
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.indicators.nominal_actuator import constants_not_given, sheet_constants
from hydrofdi.records import RecordSource
from hydrofdi.records.streams import Chunk, EvenStream, EventKind, Joining, State, Window
from hydrofdi.settings.arguments import refusal
from hydrofdi.version import __version__

NUMBER = "judging.number"
"""Key of the number of the next window in a state."""

PATIENCE = 10
"""Number of windows in a row, without overlap, after which a condition or an episode is over."""

MOST_SAMPLES = 2**22
"""Most samples of windows that are judged at once; limits the memory."""


class Detector:
    """Judges windows, and says what happens on a stream.

    The verdict on a window does not depend on other windows, nor the lines of a stream on its chunks.

    Attributes
    ----------
    file : DetectorFile
        Indicator, limits and what its promise rests on, in SI.
    path : Path or None
        Its file; None if it is not saved.
    """

    def __init__(self, file: DetectorFile, path: Path | None = None) -> None:
        self.file, self.path = file, path
        frequency, channels, window = file.sampling_frequency, file.channels, file.config.window
        self._joining, self._stream = Joining(frequency, channels), EvenStream(frequency, channels)
        self._windower = window.windower(file.n_sample, channels, frequency, file.drive)
        self._patience = PATIENCE * math.ceil(file.n_sample / file.n_every)
        chart = file.config.chart
        self._chart = None if chart is None else make_chart(chart.chart, chart.options)
        self._keys = self.start().keys()

    @classmethod
    def fit(
        cls,
        healthy: RecordSource,
        config: DetectorConfig,
        *,
        sources: Sequence[str] = (),
        faulty: RecordSource | None = None,
        is_measured: bool = False,
        command: str = "",
    ) -> Self:
        """Train a detector on healthy records.

        Parameters
        ----------
        healthy : RecordSource
            Only healthy records; the groups of their batches identify dependent records. They are read twice
            if windows start with cycles.
        config : DetectorConfig
            What is asked of it; its file contains this with all defaults.
        sources : sequence of str, optional
            Names of the sources; by default that of `healthy`.
        faulty : RecordSource, optional
            Only faulty records, for scores that learn from them too.
        is_measured : bool
            Whether a machine was measured: then the limit of a flow allows for warmer oil, if its
            temperature is not known.
        command : str
            The command that the file states as its origin.

        Raises
        ------
        ConfigError
            The indicator has no such output, no direction is stated and the output does not declare one, or
            windows are not valid.
        DataError
            The records lack a channel, or differ in sampling or length, or estimates are physically
            impossible in most windows.
        NotStatedError
            There are too few records for the false-alarm rate; the message states how many are needed.
        """
        from hydrofdi.detectors import limits, training

        if not isinstance(config, DetectorConfig):
            raise refusal("config", "a DetectorConfig (hydrofdi.train takes any data and settings)", config)
        scored = training.healthy_scores(healthy, config)
        score = scored.learn(None if config.score is None else faulty)
        scored.require_scores(healthy.name)
        chart, first, feature = limits.chart_of(scored), scored.first, scored.feature
        own, scale = limits.limits_of(scored, has_chart=chart is not None), scored.scale()
        if is_measured and verdicts.TEMPERATURE not in scored.channels and config.compensate:
            own, score = limits.with_allowance(own, score, scored)
        used = feature if score is None else feature.of(score.numbers)
        options = [each.options for each in feature.indicators.values()]
        stated = {constant for each in options for constant in sheet_constants(each)}
        is_other = scored.config.score is not None and scored.config.score.kind not in OF_ONE
        time = datetime.now(UTC).isoformat(timespec="seconds")
        file = DetectorFile(
            made=Made(hydrofdi=__version__, time=time, command=command),
            config=scored.config_in_full(chart),
            assumed=tuple(dict.fromkeys(chain.from_iterable(map(constants_not_given, options)))),
            data_sheet={key: value for key, value in healthy.data_sheet.items() if key in stated},
            indicator_versions={label: each.version for label, each in used.indicators.items()},
            score=score,
            unit="1" if is_other else output_unit(feature.indicator, feature.described, first),
            channels=scored.channels,
            sampling_frequency=first.sampling_frequency,
            n_sample=scored.n_sample,
            basis=scored.basis(sources or (healthy.name,), scale),
            healthy=scale,
            limits=own,
            chart=None if chart is None else limits.chart_limit(scored, chart, scale),
            ranges={each: verdicts.learned_range(each, facts) for each, facts in scored.facts.items()},
            conditions=scored.conditions,
            positive=scored.positive(used),
            fits=scored.fits(used),
            drive=scored.drive,
        )
        return cls(file)

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
        if not all(isinstance(window, Window) for window in windows):
            raise ConfigError("windows: expected windows of a stream ('judge' takes arrays and data frames)")
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
        parts = self._parts(state)
        stream = self._stream.resumed(parts["stream"], may_repeat=may_repeat)
        joining = self._joining.start() if may_repeat else parts["joining"]
        return _flat({**parts, "joining": joining, "stream": stream})

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Line]]:
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
        if not isinstance(chunk, Chunk):
            raise refusal("chunk", "one of hydrofdi.replay ('watch' takes arrays and data frames)", chunk)
        parts = self._parts(state)
        parts["joining"], chunk = self._joining.step(parts["joining"], chunk)
        lines = [*self._follow(parts, chunk)]
        return _flat(parts), lines

    def end(self, state: State) -> tuple[State, list[Line]]:
        """The lines at the end of a stream: counts that were not reported, and ends of episodes."""
        parts = self._parts(state)
        parts["joining"], rest = self._joining.step(parts["joining"], Chunk(np.empty(0), {}), is_end=True)
        lines = [*self._follow(parts, rest)]
        parts["defects"], sums = stream_lines.summed_up(parts["defects"])
        ends, parts["episodes"] = stream_lines.ended(parts["episodes"]), stream_lines.NO_EPISODES
        return _flat(parts), [*lines, *sums, *ends]

    def _parts(self, state: State) -> dict[str, State]:
        """A state part by part; refused if it is none of this detector."""
        if not isinstance(state, Mapping) or state.keys() != self._keys:
            raise ConfigError("state: is none of this detector; 'start' makes the first, 'step' the next")
        parts: dict[str, dict[str, Any]] = {"chart": {}}
        for key, array in state.items():
            part, _, name = key.partition(".")
            parts.setdefault(part, {})[name] = array
        return dict[str, State](parts)

    def _follow(self, parts: dict[str, State], chunk: Chunk) -> Iterator[Line]:
        """Lines of joined samples. One that is news, or begins a minute, is stepped over by itself, so that
        the place of its lines does not depend on the chunk.
        """
        stream, pieces, defects = self._stream.step(parts["stream"], chunk)
        is_news = not all(event.is_silent for event in defects)
        if defects or parts["defects"]["waiting"].any():
            is_news |= stream_lines.begins_minute(parts["defects"], pieces)
        if chunk.n_time > 1 and is_news:
            half = chunk.n_time // 2
            yield from self._follow(parts, chunk.part(0, half))
            yield from self._follow(parts, chunk.part(half, chunk.n_time))
            return
        parts["stream"] = stream
        parts["defects"], events = stream_lines.noted(parts["defects"], pieces, defects)
        yield from events
        n_at_once = self.file.n_every * max(1, MOST_SAMPLES // (self.file.n_sample * len(self.file.channels)))
        for piece in pieces:
            for first in range(0, piece.n_time, n_at_once):
                part = piece.part(first, first + n_at_once)
                parts["judging"], windows = self._windower.step(parts["judging"], part)
                for window, verdict in zip(windows, self.score(windows), strict=True):
                    yield from self._lines(parts, window, verdict)

    def _lines(self, parts: dict[str, State], window: Window, verdict: verdicts.Verdict) -> Iterator[Line]:
        """The line of a window, and the events that it causes."""
        reading, healthy = None, self.file.healthy
        if self._chart is not None and (chart := self.file.chart) is not None:
            # a window that is not judged does not change the chart
            judged = math.nan if verdict.alarm is None or verdict.score is None else verdict.score
            score = verdicts.standardised(judged, healthy, self.file.config.direction).reshape(1, 1)
            parts["chart"], statistic = self._chart.step(parts["chart"], score, chart.limit)
            value = float(statistic[0, 0])
            reading = ChartReading(None if math.isnan(value) else value, chart.limit, value >= chart.limit)
        line = WindowLine(window.number, float(window.time[0]), float(window.time[-1]), verdict, reading)
        parts["episodes"], events = stream_lines.episodes_after(parts["episodes"], self._patience, line)
        parts["conditions"], condition, alarm = stream_lines.conditioned(
            parts["conditions"], self._patience, line
        )
        yield replace(line, condition=condition)
        yield from events
        if alarm is not None and alarm.kind is EventKind.ALARM_RAISED:
            n_judged, n_alarm = (int(parts["conditions"][name]) for name in ("n_judged", "n_alarm"))
            text, details = consequence(self.file, n_judged, n_alarm, verdict.leak, verdict.margin)
            alarm = replace(alarm, text=f"{alarm.text}; {text}", details=details)
        yield from filter(None, [alarm])


def _flat(parts: Mapping[str, State]) -> State:
    return {f"{part}.{name}": array for part, state in parts.items() for name, array in state.items()}
