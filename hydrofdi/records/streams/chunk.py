"""Samples of a stream as they came."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel

State = Mapping[str, NDArray[Any]]
"""All that a stream needs from one chunk to the next: arrays, so that it can be stored."""


@dataclass(frozen=True)
class Chunk:
    """Samples as they came: neither checked nor evenly spaced. It may be a single sample, or none.

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        Sampling instants on the clock of the source [s].
    channels : mapping of Channel to ndarray, shape (n_time,)
        In SI; NaN if a sample is missing.
    unread : mapping of int to str
        Position of a sample that could not be read, with the instant NaN → why.
    """

    time: Array
    channels: Mapping[Channel, Array]
    unread: Mapping[int, str] = field(default_factory=dict)

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return int(self.time.size)

    @property
    def readable(self) -> Chunk:
        """The samples with an instant."""
        is_readable = np.isfinite(self.time)
        if is_readable.all():
            return self
        return Chunk(self.time[is_readable], {name: row[is_readable] for name, row in self.channels.items()})
