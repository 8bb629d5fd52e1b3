"""Base of the scorers of healthy records."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from hydrofdi.detectors.trained.ranges import ChannelFacts
from hydrofdi.detectors.trained.training.learned import LearnedRecord, ScoreLine
from hydrofdi.errors import Issue
from hydrofdi.records import Channel, RecordBatch


class Scorer(ABC):
    """Computes scores of records over time, and statistics of their channels.

    Parameters
    ----------
    n_sample : int
        Samples per window; 0 if estimates are judged.

    Attributes
    ----------
    facts : dict of Channel to list of ChannelFacts
    not_judged : Counter of str
        Kind of fault → number of windows or estimates that have no score.
    n_impossible, n_not_positive : Counter of str
        Output → number of windows in which it is physically impossible, or in particular not positive.
    fits : dict of str to float
        Output that states how well the model explains a window → largest value.
    """

    def __init__(self, n_sample: int) -> None:
        self.n_sample = n_sample
        self.facts: dict[Channel, list[ChannelFacts]] = {}
        self.not_judged: Counter[str] = Counter()
        self._reasons: Counter[str] = Counter()
        self.n_impossible: Counter[str] = Counter()
        self.n_not_positive: Counter[str] = Counter()
        self.fits: dict[str, float] = {}

    @property
    def reason(self) -> str:
        """Why most of them have no score; empty if all have one."""
        return next((text for text, _ in self._reasons.most_common(1)), "")

    @abstractmethod
    def lines(self, batch: RecordBatch) -> Iterator[ScoreLine]:
        """Score line of each record; the scores may be filled in later."""

    def finish(self) -> None:
        """Score all pending windows."""
        return

    @abstractmethod
    def interval(self, records: Sequence[LearnedRecord]) -> float:
        """Mean time between scores [s]."""

    def _doubt(self, doubts: Iterable[Issue], fits: Mapping[str, float]) -> None:
        """Count the doubts about a window."""
        for doubt in doubts:
            self.n_impossible[doubt.where] += doubt.kind != "misfit"
            self.n_not_positive[doubt.where] += doubt.kind == "not_positive"
        for name, value in fits.items():
            self.fits[name] = float(np.fmax(self.fits.get(name, value), value))

    def _leave_out(self, fault: Issue) -> None:
        self.not_judged[fault.kind] += 1
        self._reasons[fault.message] += 1
