"""Scores of the windows of healthy records; samples are not kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.measuring import outputs_of_records, records_of
from hydrofdi.detectors.trained.ranges import channel_facts
from hydrofdi.detectors.trained.training.cutting import windows_along
from hydrofdi.detectors.trained.training.learned import LearnedRecord, ScoreLine
from hydrofdi.detectors.trained.training.scorer import Scorer
from hydrofdi.errors import Issue
from hydrofdi.indicators.plausibility import doubts_of
from hydrofdi.records import RecordBatch
from hydrofdi.records.streams import Window, Windower
from hydrofdi.records.streams.sliding import TimeWindower

_MOST_SAMPLES = 2**21
"""Number of samples per channel that are measured at a time."""


class WindowScorer(Scorer):
    """Scores windows in batches."""

    def __init__(self, windower: Windower, feature: Feature) -> None:
        super().__init__(windower.n_sample)
        self.windower, self.feature = windower, feature
        self._waiting: list[tuple[ScoreLine, int, Window]] = []

    def lines(self, batch: RecordBatch) -> Iterator[ScoreLine]:
        """Score line of each record; the scores are filled in when enough windows are pending."""
        for row in range(batch.n_record):
            line, end = ScoreLine(batch.duration), -np.inf
            for window in windows_along(batch, row, self.windower):
                is_apart = bool(window.time[0] > end)
                end = float(window.time[-1]) if is_apart else end
                place = line.reserve(is_apart)
                if window.fault is None:
                    self._waiting.append((line, place, window))
                elif is_apart:
                    self._leave_out(window.fault)
                if len(self._waiting) * self.n_sample >= _MOST_SAMPLES:
                    self.finish()
            yield line

    def finish(self) -> None:
        """Score all pending windows."""
        if not self._waiting:
            return
        windows = [window for _, _, window in self._waiting]
        are_apart = np.array([line.is_apart[place] for line, place, _ in self._waiting])
        records = records_of(windows, self.windower.channels, self.windower.sampling_frequency)
        outputs, obstacles = outputs_of_records(records, self.feature)
        scores = outputs[self.feature.described.name]
        doubts = doubts_of(self.feature.indicator, outputs)
        fits = [each.name for each in self.feature.indicator.outputs if each.is_fit]
        for channel in self.windower.channels if are_apart.any() else ():
            self.facts.setdefault(channel, []).append(channel_facts(records[channel][are_apart]))
        for row in np.flatnonzero(are_apart & np.isfinite(scores)).tolist():
            self._doubt(doubts[row], {name: float(outputs[name][row]) for name in fits})
        for (line, place, _), score, obstacle in zip(self._waiting, scores, obstacles, strict=True):
            line.scores[place] = float(score)
            if obstacle is not None and line.is_apart[place]:
                self._leave_out(Issue(obstacle, kind="no_number"))
        self._waiting = []

    def interval(self, records: Sequence[LearnedRecord]) -> float:
        """Mean time between scores [s]."""
        if isinstance(self.windower, TimeWindower):
            return self.windower.n_every / self.windower.sampling_frequency
        n_score = sum(len(each.line.scores) for each in records)
        return sum(each.line.duration for each in records) / n_score
