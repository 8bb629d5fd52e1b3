"""Healthy records → what they teach, window by window; no samples are kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.estimating import Estimate, Estimator
from hydrofdi.detectors.trained.following import samples_looked_at
from hydrofdi.detectors.trained.measuring import feature_of, records_of, scores_of_records, without_scale
from hydrofdi.detectors.trained.ranges import ChannelFacts, channel_facts, joined, learned_range
from hydrofdi.detectors.trained.training.cutting import drive_of, pieces_along, windower_of, windows_along
from hydrofdi.detectors.trained.training.learned import Learned, LearnedRecord, ScoreLine
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.streams import Window, Windower
from hydrofdi.records.streams.sliding import TimeWindower

_MOST_SAMPLES = 2**21
"""Samples of a channel that are measured at a time."""


def learn(healthy: RecordSource, config: DetectorConfig) -> Learned:
    """What healthy records teach a detector.

    Parameters
    ----------
    healthy : RecordSource
        Healthy records alone. They are read twice where windows begin with cycles.
    config : DetectorConfig

    Raises
    ------
    ConfigError
        Indicator, output or windows are impossible.
    DataError
        Records lack a channel, or differ in sampling or length.
    NotStatedError
        There is no healthy record, or none has the number.
    """
    feature, window = feature_of(config), config.window
    drive = drive_of(healthy, window.channel) if window.by == "cycle" else None
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    first = next(batches, None)
    if first is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    channels = _channels(feature, config, first)
    scorer: _WindowScorer | _EstimateScorer
    if window.by == "estimate":
        scorer = _EstimateScorer(_estimator(feature, config, channels, first), channels)
    else:
        scorer = _WindowScorer(windower_of(window, first, channels, drive), feature)
    records = [
        LearnedRecord(
            batch.record_ids[row], batch.groups[row], batch.labels[row] if batch.labels else "", line
        )
        for batch in chain([first], batches)
        for row, line in enumerate(scorer.lines(_alike(batch, first, channels, config)))
    ]
    scorer.finish()
    if not any(each.line.chosen.size for each in records):
        raise NotStatedError(
            f"no healthy record has {feature.label}: {scorer.reason or 'they are too short'}"
        )
    return Learned(
        records=records,
        feature=feature,
        unit=output_unit(feature.indicator, feature.described, first),
        channels=channels,
        sampling_frequency=first.sampling_frequency,
        n_sample=scorer.n_sample,
        interval=scorer.interval(records),
        ranges={channel: learned_range(channel, joined(facts)) for channel, facts in scorer.facts.items()},
        drive=drive,
        not_judged=dict(sorted(scorer.not_judged.items())),
    )


class _WindowScorer:
    """Scores windows, many at a time."""

    def __init__(self, windower: Windower, feature: Feature) -> None:
        self.windower, self.feature = windower, feature
        self.n_sample = windower.n_sample
        self.facts: dict[Channel, list[ChannelFacts]] = {}
        self.not_judged: Counter[str] = Counter()
        self.reason = ""
        self._waiting: list[tuple[ScoreLine, int, Window]] = []

    def lines(self, batch: RecordBatch) -> Iterator[ScoreLine]:
        """A line for each record; its scores follow when enough windows wait."""
        for row in range(batch.n_record):
            line, end = ScoreLine(batch.duration), -np.inf
            for window in windows_along(batch, row, self.windower):
                is_apart = bool(window.time[0] > end)
                end = float(window.time[-1]) if is_apart else end
                place = line.reserve(is_apart)
                if window.fault is None:
                    self._waiting.append((line, place, window))
                elif is_apart:
                    self.not_judged[window.fault.kind] += 1
                if len(self._waiting) * self.n_sample >= _MOST_SAMPLES:
                    self.finish()
            yield line

    def finish(self) -> None:
        """Score all windows that wait."""
        if not self._waiting:
            return
        windows = [window for _, _, window in self._waiting]
        are_apart = np.array([line.is_apart[place] for line, place, _ in self._waiting])
        records = records_of(windows, self.windower.channels, self.windower.sampling_frequency)
        scores = scores_of_records(records, self.feature)
        for channel in self.windower.channels if are_apart.any() else ():
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_apart]))
        for (line, place, _), score, obstacle in zip(
            self._waiting, scores.values, scores.obstacles, strict=True
        ):
            line.scores[place] = float(score)
            if obstacle is not None and line.is_apart[place]:
                self.not_judged["no_number"] += 1
                self.reason = self.reason or obstacle
        self._waiting = []

    def interval(self, records: Sequence[LearnedRecord]) -> float:
        """Mean time from one score to the next [s]."""
        if (n_every := getattr(self.windower, "n_every", None)) is not None:
            return float(n_every / self.windower.sampling_frequency)
        n_score = sum(len(each.line.scores) for each in records)
        return sum(each.line.duration for each in records) / n_score


class _EstimateScorer:
    """Follows records by a recursive indicator."""

    n_sample = 0

    def __init__(self, estimator: Estimator, channels: Sequence[Channel]) -> None:
        self.estimator, self.channels = estimator, channels
        self.facts: dict[Channel, list[ChannelFacts]] = {}
        self.not_judged: Counter[str] = Counter()
        self.reason = ""
        self._interval = 0.0
        n_look = samples_looked_at(estimator.indicator, estimator.sampling_frequency)
        self._looks = TimeWindower(n_look, n_look, tuple(channels), estimator.sampling_frequency)

    def lines(self, batch: RecordBatch) -> Iterator[ScoreLine]:
        """A line for each record."""
        samples = self.estimator.indicator.samples_per_estimate(batch.sampling_frequency)
        self._interval = samples / batch.sampling_frequency
        for row in range(batch.n_record):
            line, state = ScoreLine(batch.duration), self.estimator.start()
            for piece in pieces_along(batch, row, self.channels):
                state, found = self.estimator.step(state, piece)
                self._take(line, found)
            for window in windows_along(batch, row, self._looks):
                if window.fault is None:
                    self._look_at(window)
            yield line

    def _look_at(self, window: Window) -> None:
        for channel in self.channels:
            self.facts.setdefault(channel, []).append(channel_facts(window.channels[channel][None]))

    def _take(self, line: ScoreLine, found: Sequence[Estimate]) -> None:
        for each in found:
            line.scores[line.reserve(is_apart=True)] = each.score
            if each.fault is not None:
                self.not_judged[each.fault.kind] += 1
                self.reason = self.reason or each.fault.text

    def finish(self) -> None:
        """Nothing waits."""

    def interval(self, records: Sequence[LearnedRecord]) -> float:
        """Time from one estimate to the next [s]."""
        return self._interval


def _channels(feature: Feature, config: DetectorConfig, first: RecordBatch) -> tuple[Channel, ...]:
    """What a window needs: optional channels of the indicator, too, where the healthy records have them."""
    indicator = feature.indicator
    seen = indicator.channels | (indicator.optional_channels & first.channels.keys())
    if config.window.by == "cycle":
        seen |= {config.window.channel}
    return tuple(channel for channel in Channel if channel in seen)


def _estimator(
    feature: Feature, config: DetectorConfig, channels: Sequence[Channel], first: RecordBatch
) -> Estimator:
    if config.window.duration is not None or config.window.every is not None:
        raise ConfigError(
            f"--by estimate: there are no windows; the option 'interval' of {feature.indicator.name} says how"
            " often an estimate comes"
        )
    return Estimator(feature, channels, first.sampling_frequency)


def _alike(
    batch: RecordBatch, first: RecordBatch, channels: Sequence[Channel], config: DetectorConfig
) -> RecordBatch:
    """The batch, where it is like the first one.

    Raises
    ------
    DataError
        It is not.
    """
    source, other = batch.sources[0], first.sources[0]
    if batch.sampling_frequency != first.sampling_frequency:
        raise DataError(
            f"{source}: is sampled at {batch.sampling_frequency:g} Hz, and {other} at"
            f" {first.sampling_frequency:g} Hz; a detector has one sampling frequency"
        )
    if missing := [channel for channel in channels if channel not in batch.channels]:
        raise DataError(f"{source}: has no {' and no '.join(missing)}, which {config.indicator} needs")
    if obstacle := without_scale(batch, channels):
        raise DataError(f"{source}: {obstacle}")
    needs_length = config.window.by == "time" and config.window.duration is None
    if needs_length and batch.n_time != first.n_time:
        raise DataError(
            f"{source}: lasts {batch.duration:g} s, and {other} {first.duration:g} s; state the duration of a"
            " window with --window"
        )
    return batch
