"""Scores of healthy records from estimates of a recursive indicator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hydrofdi.detectors.trained.estimating import Estimate, Estimator
from hydrofdi.detectors.trained.following import samples_looked_at
from hydrofdi.detectors.trained.ranges import channel_facts
from hydrofdi.detectors.trained.training.cutting import pieces_along, windows_along
from hydrofdi.detectors.trained.training.learned import LearnedRecord, ScoreLine
from hydrofdi.detectors.trained.training.scorer import Scorer
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.streams import Window
from hydrofdi.records.streams.sliding import TimeWindower


class EstimateScorer(Scorer):
    """Scores records with a recursive indicator."""

    def __init__(self, estimator: Estimator, channels: Sequence[Channel]) -> None:
        super().__init__(0)
        self.estimator, self.channels = estimator, channels
        n_look = samples_looked_at(estimator.indicator, estimator.sampling_frequency)
        self._looks = TimeWindower(n_look, n_look, tuple(channels), estimator.sampling_frequency)

    def lines(self, batch: RecordBatch) -> Iterator[ScoreLine]:
        """Score line of each record."""
        for row in range(batch.n_record):
            line, state = ScoreLine(batch.duration), self.estimator.start()
            for piece in pieces_along(batch, row, self.channels):
                state, found = self.estimator.step(state, piece)
                self._take(line, found)
            for window in windows_along(batch, row, self._looks):
                if window.fault is None:
                    self._collect_statistics(window)
            yield line

    def _collect_statistics(self, window: Window) -> None:
        for channel in self.channels:
            self.facts.setdefault(channel, []).append(channel_facts(window.channels[channel][None]))

    def _take(self, line: ScoreLine, found: Sequence[Estimate]) -> None:
        for each in found:
            line.scores[line.reserve(is_apart=True)] = each.score
            self._doubt(each.doubts, each.fits)
            if each.fault is not None:
                self._leave_out(each.fault)

    def interval(self, records: Sequence[LearnedRecord]) -> float:
        """Time between estimates [s]."""
        return self.estimator.interval
