"""Samples of a stream as they came."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

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
    """

    time: Array
    channels: Mapping[Channel, Array]

    @property
    def n_time(self) -> int:
        """Number of samples."""
        return int(self.time.size)
