"""Results of training on healthy records: scores of windows, and ranges of channels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.file import ChannelRange
from hydrofdi.records import Array, Channel


@dataclass(eq=False)
class ScoreLine:
    """Scores along a record, as the detector will give them.

    Attributes
    ----------
    duration : float
        Of the record [s].
    scores : list of float
        NaN if there is none.
    is_apart : list of bool
        Whether a score sets limits: windows that do so do not overlap.
    """

    duration: float
    scores: list[float] = field(default_factory=list)
    is_apart: list[bool] = field(default_factory=list)

    def reserve(self, is_apart: bool) -> int:
        """The place of the next score."""
        self.scores.append(math.nan)
        self.is_apart.append(is_apart)
        return len(self.scores) - 1

    @cached_property
    def chosen(self) -> Array:
        """Scores that set limits."""
        pairs = zip(self.scores, self.is_apart, strict=True)
        return np.array([score for score, is_apart in pairs if is_apart and not math.isnan(score)])


@dataclass(frozen=True, eq=False)
class LearnedRecord:
    """A healthy record: where it comes from, as far as that is known, and its scores."""

    record_id: str
    group: str
    label: str
    line: ScoreLine


@dataclass(frozen=True, eq=False)
class Learned:
    """All that healthy records taught.

    Attributes
    ----------
    records : sequence of LearnedRecord
    feature : Feature
    unit : str
        Of the score.
    channels : tuple of Channel
        What a window needs.
    sampling_frequency : float
        [Hz]
    n_sample : int
        Samples of a window; 0 where estimates are judged.
    interval : float
        Time from one score to the next [s].
    ranges : mapping of Channel to ChannelRange
    drive : tuple of float or None
        Range of the channel whose edges start cycles.
    not_judged : mapping of str to int
        Kind of fault → number of windows, of those that do not overlap.
    """

    records: Sequence[LearnedRecord]
    feature: Feature
    unit: str
    channels: tuple[Channel, ...]
    sampling_frequency: float
    n_sample: int
    interval: float
    ranges: Mapping[Channel, ChannelRange]
    drive: tuple[float, float] | None
    not_judged: Mapping[str, int]

    @cached_property
    def scores(self) -> Array:
        """All scores that set limits."""
        return np.concatenate([each.line.chosen for each in self.records])

    @cached_property
    def groups(self) -> list[str]:
        """Group of each record; a record without one is a group by itself."""
        return [each.group or f"record {place}" for place, each in enumerate(self.records)]

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Number of the group of each score that sets limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return np.repeat(numbers, [each.line.chosen.size for each in self.records])

    @property
    def has_groups(self) -> bool:
        """Whether anybody stated groups."""
        return any(each.group for each in self.records)

    @property
    def duration(self) -> float:
        """Of a window; the time between estimates where those are judged [s]."""
        return self.n_sample / self.sampling_frequency if self.n_sample else self.interval
