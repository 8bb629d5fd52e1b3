"""Healthy records → what they teach, batch by batch; no samples are kept."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.cutting import Cut, apart, cut_of
from hydrofdi.detectors.trained.following import Estimator
from hydrofdi.detectors.trained.learned import Learned, LearnedRecord
from hydrofdi.detectors.trained.measuring import feature_of, records_of, scores_of_records
from hydrofdi.detectors.trained.ranges import ChannelFacts, channel_facts, joined, learned_range
from hydrofdi.errors import DataError
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.indicators.measuring import output_unit
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.streams import Window

_MOST_SAMPLES = 2**21
"""Samples of a channel that are measured at a time."""


def learn(healthy: RecordSource, config: DetectorConfig) -> Learned:
    """What healthy records teach a detector.

    Parameters
    ----------
    healthy : RecordSource
        Healthy records alone.
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
    feature = feature_of(config)
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    first = next(batches, None)
    if first is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    cut = None if config.window.by == "estimate" else cut_of(config.window, first)
    learner = _Learner(feature, config, first, cut)
    for batch in chain([first], batches):
        learner.take(batch)
    return learner.learned()


@dataclass
class _Learner:
    feature: Feature
    config: DetectorConfig
    first: RecordBatch
    cut: Cut | None
    records: list[LearnedRecord] = field(default_factory=list)
    facts: dict[Channel, list[ChannelFacts]] = field(default_factory=dict)
    not_judged: Counter[str] = field(default_factory=Counter)
    reason: str = ""

    def __post_init__(self) -> None:
        indicator = self.feature.indicator
        seen = indicator.channels | (indicator.optional_channels & self.first.channels.keys())
        if self.config.window.by == "cycle":
            seen |= {self.config.window.channel}
        self.channels = tuple(channel for channel in Channel if channel in seen)

    def take(self, batch: RecordBatch) -> None:
        """Learn from a batch."""
        self._require_alike(batch)
        if self.cut is None:
            for row in range(batch.n_record):
                scores = self._estimates(batch, row)
                self._keep(batch, row, scores, np.isfinite(scores))
            return
        windows = [list(self.cut.windows(batch.time, _of_row(batch, row))) for row in range(batch.n_record)]
        chosen = [apart(own) for own in windows]
        scores = self._scores([each for own in windows for each in own], np.concatenate(chosen))
        ends = np.cumsum([len(own) for own in windows])[:-1]
        for row, (values, own) in enumerate(zip(np.split(scores, ends), chosen, strict=True)):
            self._keep(batch, row, values, own & np.isfinite(values))

    def learned(self) -> Learned:
        """All of it.

        Raises
        ------
        NotStatedError
            No healthy record has a score.
        """
        frequency = self.first.sampling_frequency
        if not any(each.sets_limits.any() for each in self.records):
            raise NotStatedError(f"no healthy record has {self.feature.label}: {self.reason or 'too short'}")
        return Learned(
            self.records,
            self.feature,
            output_unit(self.feature.indicator, self.feature.described, self.first),
            self.channels,
            frequency,
            0 if self.cut is None else self.cut.n_sample,
            self._samples_between() / frequency,
            {channel: learned_range(channel, joined(facts)) for channel, facts in self.facts.items()},
            None,
            dict(sorted(self.not_judged.items())),
        )

    def _samples_between(self) -> int:
        if self.cut is not None:
            return self.cut.n_every
        return self._estimator.indicator.samples_per_estimate(self.first.sampling_frequency)

    @property
    def _estimator(self) -> Estimator:
        return Estimator(self.feature, self.channels, self.first.sampling_frequency)

    def _estimates(self, batch: RecordBatch, row: int) -> Array:
        estimator = self._estimator
        piece = _Piece(batch.time, _of_row(batch, row))
        _, found = estimator.step(estimator.start(), piece)
        self.not_judged.update(each.fault.kind for each in found if each.fault is not None)
        return np.array([each.score for each in found])

    def _scores(self, windows: Sequence[Window], are_chosen: Sequence[bool]) -> Array:
        scores = np.full(len(windows), np.nan)
        sound = []
        for place, (window, is_chosen) in enumerate(zip(windows, are_chosen, strict=True)):
            if window.fault is None:
                sound.append(place)
            elif is_chosen:
                self.not_judged[window.fault.kind] += 1
        n_sample = self.cut.n_sample if self.cut else 1
        n_block = max(1, _MOST_SAMPLES // n_sample)
        for start in range(0, len(sound), n_block):
            places = sound[start : start + n_block]
            scores[places] = self._measured(
                [windows[place] for place in places], np.asarray(are_chosen)[places]
            )
        return scores

    def _measured(self, windows: Sequence[Window], are_chosen: Array) -> Array:
        records = records_of(windows, self.channels, self.first.sampling_frequency)
        scores = scores_of_records(records, self.feature)
        for channel in self.channels:
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_chosen]))
        without = [
            each for each, is_chosen in zip(scores.obstacles, are_chosen, strict=True) if each and is_chosen
        ]
        self.not_judged.update({"no_number": len(without)} if without else {})
        self.reason = self.reason or next(iter(without), "")
        return scores.values

    def _keep(self, batch: RecordBatch, row: int, scores: Array, sets_limits: Array) -> None:
        label = batch.labels[row] if batch.labels else ""
        place = batch.record_ids[row], batch.sources[row], batch.groups[row], label
        self.records.append(LearnedRecord(*place, scores, sets_limits))

    def _require_alike(self, batch: RecordBatch) -> None:
        first, source = self.first, batch.sources[0]
        if batch.sampling_frequency != first.sampling_frequency:
            raise DataError(
                f"{source}: is sampled at {batch.sampling_frequency:g} Hz, and {first.sources[0]} at"
                f" {first.sampling_frequency:g} Hz; a detector has one sampling frequency"
            )
        if missing := [channel for channel in self.channels if channel not in batch.channels]:
            raise DataError(f"{source}: has no {' and no '.join(missing)}, which {self.feature.label} needs")
        if (batch.relative, batch.normalized) != (first.relative, first.normalized):
            raise DataError(
                f"{source}: has channels in counts that {first.sources[0]} has in SI, or the reverse"
            )
        is_default = self.cut is not None and self.config.window.duration is None
        if is_default and batch.n_time != first.n_time:
            raise DataError(
                f"{source}: lasts {batch.duration:g} s, and {first.sources[0]} {first.duration:g} s; state the"
                " duration of a window with --window"
            )


@dataclass(frozen=True)
class _Piece:
    time: Array
    channels: dict[Channel, Array]
    begins_anew: bool = True


def _of_row(batch: RecordBatch, row: int) -> dict[Channel, Array]:
    return {channel: samples[row] for channel, samples in batch.channels.items()}
