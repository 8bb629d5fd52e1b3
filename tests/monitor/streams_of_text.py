"""Texts and the samples in them, for tests of sources."""

from itertools import pairwise

import numpy as np

from hydrofdi.monitor.configuration import LimitsConfig, MonitorConfig, TextConfig
from hydrofdi.monitor.sources.contract import joined
from hydrofdi.monitor.sources.text_lines import TextLines


def config_of(channels=None, largest=2**20, **text):
    """A configuration of a monitor; its largest line or message may be smaller than a user may state."""
    limits = LimitsConfig.model_construct(payload=largest)
    return MonitorConfig.model_construct(channels=channels or {}, text=TextConfig(**text), limits=limits)


def reader(position=(), needed=(), **options):
    return TextLines(config_of(**options), "the stream", dict(position), needed)


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
