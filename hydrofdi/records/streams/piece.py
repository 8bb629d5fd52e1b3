"""Consecutive samples of a stream."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk


@dataclass(frozen=True)
class Piece:
    """Consecutive accepted samples of a stream, without a gap.

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        [s]
    channels : mapping of Channel to ndarray, shape (n_time,)
        All requested channels, in SI; NaN if a sample is missing.
    begins_anew : bool
        Whether it does not continue the piece before: it is the first, or follows a gap or a clock change.
    """

    time: Array
    channels: Mapping[Channel, Array]
    begins_anew: bool


def whole(chunk: Chunk, channels: Sequence[Channel]) -> Piece:
    """A whole chunk as a piece that continues without a gap, with the requested channels."""
    return Piece(chunk.time, _rows(chunk, channels), begins_anew=False)


def pieces_of(
    chunk: Chunk, channels: Sequence[Channel], accepted: NDArray[np.intp], anew: NDArray[np.intp]
) -> list[Piece]:
    """Accepted samples of a chunk.

    Parameters
    ----------
    chunk : Chunk
    channels : sequence of Channel
        Channels of the pieces.
    accepted : ndarray of int
        Positions of the accepted samples, in order.
    anew : ndarray of int
        Positions of those that do not continue the sample before.
    """
    if not accepted.size:
        return []
    time, rows = chunk.time, _rows(chunk, channels)
    if accepted.size < chunk.n_time:
        time, rows = time[accepted], {channel: row[accepted] for channel, row in rows.items()}
    firsts = np.searchsorted(accepted, anew)
    bounds = np.union1d(firsts, [0, accepted.size]).astype(np.intp).tolist()
    begins = set(firsts.tolist())
    return [
        Piece(time[first:stop], {channel: row[first:stop] for channel, row in rows.items()}, first in begins)
        for first, stop in pairwise(bounds)
    ]


def _rows(chunk: Chunk, channels: Sequence[Channel]) -> dict[Channel, Array]:
    rows = {channel: chunk.channels.get(channel) for channel in channels}
    return {channel: np.full(chunk.n_time, np.nan) if row is None else row for channel, row in rows.items()}
