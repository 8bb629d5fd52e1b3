"""Samples of a stream, and windows of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel

State = Mapping[str, NDArray[Any]]
"""All that a stream needs from one chunk to the next: arrays, so that it can be stored."""


@dataclass(frozen=True)
class Chunk:
    """Samples of a stream: as they came, neither checked nor evenly spaced, perhaps a single one or none;
    after `EvenStream`, accepted samples with all requested channels and without a gap.

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        Sampling instants on the clock of the source [s].
    channels : mapping of Channel to ndarray, shape (n_time,)
        In SI; NaN if a sample is missing.
    unread : mapping of int to str
        Position of a sample that could not be read, with the instant NaN → why.
    begins_anew : bool
        Of accepted samples: whether they do not continue those before, because they are the first, or follow
        a gap or a clock change.
    """

    time: Array
    channels: Mapping[Channel, Array]
    unread: Mapping[int, str] = field(default_factory=dict)
    begins_anew: bool = False

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return int(self.time.size)

    def part(self, first: int, stop: int) -> Chunk:
        """The samples from `first` to before `stop`."""
        rows = {channel: row[first:stop] for channel, row in self.channels.items()}
        unread = {place - first: text for place, text in self.unread.items() if first <= place < stop}
        return Chunk(self.time[first:stop], rows, unread, self.begins_anew and first == 0)

    @property
    def readable(self) -> Chunk:
        """The samples with an instant."""
        is_readable = np.isfinite(self.time)
        if is_readable.all():
            return self
        return Chunk(self.time[is_readable], {name: row[is_readable] for name, row in self.channels.items()})


@dataclass(frozen=True)
class Window:
    """Consecutive samples of a stream, without a gap.

    Attributes
    ----------
    number : int
        From 0, in the order of their ends; it continues after gaps and restarts.
    time : ndarray, shape (n_time,)
        Sampling instants as the source stated them [s].
    channels : mapping of Channel to ndarray, shape (n_time,)
        In SI.
    fault : Issue or None
        Why it cannot be judged; None if no fault is found so far.
    """

    number: int
    time: Array
    channels: Mapping[Channel, Array]
    fault: Issue | None = None
