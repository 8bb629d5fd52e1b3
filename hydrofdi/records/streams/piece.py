"""Samples of a stream that follow each other."""

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
    """Consecutive samples of a stream that were accepted, without a gap.

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        [s]
    channels : mapping of Channel to ndarray, shape (n_time,)
        All channels that were asked for, in SI; NaN if a sample is missing.
    begins_anew : bool
        Whether it does not continue the piece before: it is the first one, or a gap came before.
    """

    time: Array
    channels: Mapping[Channel, Array]
    begins_anew: bool


def whole(chunk: Chunk, channels: Sequence[Channel]) -> Piece:
    """All of a chunk, which continues without a gap; with the channels that are asked for."""
    return Piece(chunk.time, _rows(chunk, channels), begins_anew=False)


def pieces_of(
    chunk: Chunk, channels: Sequence[Channel], accepted: NDArray[np.intp], anew: NDArray[np.intp]
) -> list[Piece]:
    """Accepted samples of a chunk.

    Parameters
    ----------
    chunk : Chunk
    channels : sequence of Channel
        What pieces have.
    accepted : ndarray of int
        Samples that pieces consist of, in order.
    anew : ndarray of int
        Those among them that begin anew.
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
