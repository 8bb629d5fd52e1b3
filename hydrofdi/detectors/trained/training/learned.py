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
    """Scores of a record over time, as the detector computes them.

    Attributes
    ----------
    duration : float
        Duration of the record [s].
    scores : list of float
        Scores; NaN if there is none.
    is_apart : list of bool
        Whether a score is used to set limits: only those of non-overlapping windows are.
    """

    duration: float
    scores: list[float] = field(default_factory=list)
    is_apart: list[bool] = field(default_factory=list)

    def reserve(self, is_apart: bool) -> int:
        """Append a placeholder for the next score, and return its index."""
        self.scores.append(math.nan)
        self.is_apart.append(is_apart)
        return len(self.scores) - 1

    @cached_property
    def chosen(self) -> Array:
        """Scores that are used to set limits."""
        pairs = zip(self.scores, self.is_apart, strict=True)
        return np.array([score for score, is_apart in pairs if is_apart and not math.isnan(score)])


@dataclass(frozen=True, eq=False)
class LearnedRecord:
    """A healthy record: its origin, if known, and its scores."""

    record_id: str
    group: str
    label: str
    line: ScoreLine


@dataclass(frozen=True, eq=False)
class Learned:
    """Training results of all healthy records.

    Attributes
    ----------
    records : sequence of LearnedRecord
    feature : Feature
    unit : str
        Unit of the score.
    channels : tuple of Channel
        Channels that a window needs.
    sampling_frequency : float
        [Hz]
    n_sample : int
        Samples per window; 0 if estimates are judged.
    interval : float
        Time between scores [s].
    ranges : mapping of Channel to ChannelRange
    drive : tuple of float or None
        Range of the channel whose edges start cycles.
    not_judged : mapping of str to int
        Kind of fault → number of non-overlapping windows.
    positive : tuple of str
        Quantities that can only be positive, and are so in all windows.
    impossible : dict of str to int
        Output → number of windows in which it is physically impossible.
    fits : dict of str to float
        Output that states how well the model explains a window → largest value.
    drive_period : float or None
        Period of the drive of the first record [s].
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
    positive: tuple[str, ...] = ()
    impossible: dict[str, int] = field(default_factory=dict)
    fits: dict[str, float] = field(default_factory=dict)
    drive_period: float | None = None

    @cached_property
    def scores(self) -> Array:
        """All scores that are used to set limits."""
        return np.concatenate([each.line.chosen for each in self.records])

    @cached_property
    def groups(self) -> list[str]:
        """Group of each record; a record without a group is its own group."""
        return [each.group or f"record {place}" for place, each in enumerate(self.records)]

    @cached_property
    def of_scores(self) -> NDArray[np.intp]:
        """Group index of each score that is used to set limits."""
        numbers = np.unique(np.asarray(self.groups), return_inverse=True)[1]
        return np.repeat(numbers, [each.line.chosen.size for each in self.records])

    @property
    def has_groups(self) -> bool:
        """Whether groups were stated."""
        return any(each.group for each in self.records)

    @property
    def duration(self) -> float:
        """Duration of a window, or time between estimates if those are judged [s]."""
        return self.n_sample / self.sampling_frequency if self.n_sample else self.interval
