"""Texts and the samples in them, for tests of sources."""

from itertools import pairwise

import numpy as np

from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.contract import joined
from hydrofdi.monitor.sources.text_lines import TextLines
from hydrofdi.records.measured.description.sections import FormatConfig, LimitsConfig


def config_of(channels=None, largest=2**20, **options):
    """A configuration of a monitor; its largest line or message may be smaller than a user may state."""
    form = {key: options.pop(key) for key in [*options] if key in FormatConfig.model_fields}
    config = MonitorConfig(channels=channels or {}, format=form, **options)
    return config.model_copy(update={"limits": LimitsConfig.model_construct(payload=largest)})


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
