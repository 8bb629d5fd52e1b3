"""How the healthy records are cut, as the detector will cut what it judges."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.trained.configuration import WindowConfig
from hydrofdi.errors import ConfigError
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window


@dataclass(frozen=True)
class Cut:
    """Windows of a stream in samples.

    Attributes
    ----------
    n_sample, n_every : int
        Samples of a window, and from the start of one to the start of the next.
    """

    n_sample: int
    n_every: int

    def windows(self, time: Array, channels: dict[Channel, Array]) -> Iterator[Window]:
        """The windows of a record."""
        for number, first in enumerate(range(0, time.size - self.n_sample + 1, self.n_every)):
            part = slice(first, first + self.n_sample)
            own = {channel: samples[part] for channel, samples in channels.items()}
            yield Window(number, time[part], own)


def cut_of(window: WindowConfig, records: RecordBatch) -> Cut:
    """The windows that a configuration means; those of whole records where it states no duration.

    Raises
    ------
    ConfigError
        A window would hold fewer than two samples, or be longer than the records.
    """
    frequency = records.sampling_frequency
    duration = records.duration if window.duration is None else window.duration
    n_sample = round(duration * frequency)
    if n_sample < 2:
        raise ConfigError(
            f"--window: {duration:g} s at {frequency:g} Hz hold {n_sample} samples; 2 are needed"
        )
    every = duration if window.every is None else window.every
    return Cut(n_sample, max(1, round(every * frequency)))


def apart(windows: Sequence[Window]) -> NDArray[np.bool_]:
    """Windows that do not overlap: the first, and then each that begins after the last chosen one."""
    chosen, end = np.zeros(len(windows), dtype=bool), -np.inf
    for place, window in enumerate(windows):
        if window.time[0] > end:
            chosen[place], end = True, float(window.time[-1])
    return chosen
