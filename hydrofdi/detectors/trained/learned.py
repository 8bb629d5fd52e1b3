"""What healthy records taught: scores of their windows, and what their channels showed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.file import ChannelRange
from hydrofdi.records import Array, Channel


@dataclass(frozen=True, eq=False)
class LearnedRecord:
    """A healthy record.

    Attributes
    ----------
    record_id, source, group, label : str
        Empty where nothing is known.
    scores : ndarray, shape (n_score,)
        Of its windows, as the detector will cut them, or of its estimates; NaN where there is none.
    sets_limits : ndarray of bool, shape (n_score,)
        Scores of windows that do not overlap.
    """

    record_id: str
    source: str
    group: str
    label: str
    scores: Array
    sets_limits: NDArray[np.bool_]

    @property
    def chosen(self) -> Array:
        """Scores that set limits."""
        return self.scores[self.sets_limits]


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

    @property
    def scores(self) -> Array:
        """All scores that set limits."""
        return np.concatenate([each.chosen for each in self.records] or [np.empty(0)])

    @property
    def has_groups(self) -> bool:
        """Whether anybody stated groups."""
        return any(each.group for each in self.records)

    @property
    def groups(self) -> list[str]:
        """Group of each record; a record without one is a group by itself."""
        return [each.group or f"record {place}" for place, each in enumerate(self.records)]
