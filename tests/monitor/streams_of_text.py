"""Texts and the samples in them, for tests of sources."""

from itertools import pairwise

import numpy as np

from hydrofdi.monitor.sources.joining import joined
from hydrofdi.monitor.sources.payload import LARGEST
from hydrofdi.monitor.sources.text.config import TextConfig
from hydrofdi.monitor.sources.text.lines import TextLines


def reader(position=(), channels=None, largest=LARGEST, needed=(), **options):
    return TextLines(channels or {}, TextConfig(**options), "the stream", dict(position), largest, needed)


def read_in_pieces(lines, data, cuts=()):
    """All samples of bytes that come in pieces, and why the others could not be read."""
    places = [0, *sorted(min(cut, len(data)) for cut in cuts), len(data)]
    readings = [lines.read(data[a:b]) for a, b in pairwise(places)]
    readings.append(lines.read(b"", is_end=True))
    chunk = joined([chunk for chunk in readings if chunk is not None])
    return chunk.readable, [chunk.unread[place] for place in sorted(chunk.unread)]


def samples(chunk):
    """Time and channels as lists, for comparison; NaN is None."""
    arrays = {"time": chunk.time} | {channel.symbol: values for channel, values in chunk.channels.items()}
    return {
        name: [None if np.isnan(value) else value for value in values.tolist()]
        for name, values in arrays.items()
    }
