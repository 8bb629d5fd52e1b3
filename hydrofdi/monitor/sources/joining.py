"""Concatenated chunks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.records.streams import Chunk


def joined(chunks: Sequence[Chunk]) -> Chunk:
    """All samples in one chunk; NaN for a channel that a chunk does not have."""
    if len(chunks) == 1:
        return chunks[0]
    channels = dict.fromkeys(channel for chunk in chunks for channel in chunk.channels)
    return Chunk(
        np.concatenate([np.empty(0), *(chunk.time for chunk in chunks)]),
        {
            channel: np.concatenate(
                [
                    np.full(chunk.n_time, np.nan) if (own := chunk.channels.get(channel)) is None else own
                    for chunk in chunks
                ]
            )
            for channel in channels
        },
        {
            int(first) + place: text
            for first, chunk in zip(np.cumsum([0, *(chunk.n_time for chunk in chunks)]), chunks, strict=False)
            for place, text in chunk.unread.items()
        },
    )
