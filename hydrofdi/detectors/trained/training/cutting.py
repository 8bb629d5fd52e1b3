"""Division of healthy records into the same windows that the detector cuts from a stream."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from hydrofdi.detectors.trained.configuration import WindowConfig
from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.streams import Chunk, EvenStream, Window, Windower

_CHUNK = 2**17
"""Number of samples of a record that are cut at a time; overlapping windows multiply their memory."""

Drive = tuple[float, float]


def windower_of(
    window: WindowConfig, first: RecordBatch, channels: Sequence[Channel], drive: Drive | None
) -> Windower:
    """Make the windower of a configuration; without a duration, windows are whole records.

    Raises
    ------
    ConfigError
        A window would contain fewer than two samples, or cycles have no duration.
    """
    assert window.by != "estimate"
    frequency = first.sampling_frequency
    if window.by == "cycle" and window.duration is None:
        raise ConfigError("by=cycle: give the length of each cycle, counted from its edge, as 'window'")
    if window.by == "cycle" and window.every is not None:
        raise ConfigError("every: windows by cycle start at the edges of the drive; remove this setting")
    duration = first.duration if window.duration is None else window.duration
    n_sample = round(duration * frequency)
    if n_sample < 2:
        raise ConfigError(
            f"window: {duration:g} s at {frequency:g} Hz contain {n_sample} samples; use at least 2"
        )
    return window.windower(n_sample, channels, frequency, drive)


def windows_along(records: RecordBatch, row: int, windower: Windower) -> Iterator[Window]:
    """Windows of a record, a few at a time."""
    state = windower.start()
    for piece in pieces_along(records, row, windower.needs):
        state, windows = windower.step(state, piece)
        yield from windows


def pieces_along(records: RecordBatch, row: int, channels: Collection[Channel]) -> Iterator[Chunk]:
    """Pieces of a record, as from a stream."""
    stream = EvenStream(records.sampling_frequency, tuple(channels))
    state, time = stream.start(), records.time
    for first in range(0, records.n_time, _CHUNK):
        part = slice(first, first + _CHUNK)
        chunk = Chunk(time[part], {channel: records[channel][row, part] for channel in channels})
        state, pieces, _ = stream.step(state, chunk)
        yield from pieces


def drive_of(healthy: RecordSource, channel: Channel) -> Drive:
    """Lowest and highest value of the channel whose edges start cycles, over all healthy records.

    Raises
    ------
    NotStatedError
        No record has the channel, or it never changes.
    """
    low, high = np.inf, -np.inf
    for batch in healthy.batches(labels=True):
        if batch.n_record and channel in batch.channels:
            low = min(low, float(np.nanmin(batch[channel])))
            high = max(high, float(np.nanmax(batch[channel])))
    if not low < high:
        found = "is missing in" if high == -np.inf else "never changes in"
        raise NotStatedError(
            f"by=cycle: {channel} {found} all healthy records, but cycles start at its edges;"
            " choose another channel under 'window:', or use windows by time"
        )
    return low, high
