"""Windows of a stream, and their faults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel


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
