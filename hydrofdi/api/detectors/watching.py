"""Chunks of samples in memory → the lines of a monitor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from hydrofdi.api.records.columns import held
from hydrofdi.api.records.held import records_of
from hydrofdi.api.records.sources import Said
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import DataError
from hydrofdi.monitor.lines import line_record
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.measured.recording import samples_of
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.counting import counted


def watched(file: DetectorFile, chunks: Iterable[Any], said: Said) -> Iterator[dict[str, Any]]:
    """The lines of a stream, as they come.

    Raises
    ------
    ConfigError, DataError
        A chunk lacks channels, units or times.
    """
    watch = Watch(file)
    state = watch.start()
    for chunk in _chunks(chunks, said, said.frequency or file.sampling_frequency):
        state, lines = watch.step(state, chunk)
        yield from (line_record(line, file.unit) for line in lines)
    yield from (line_record(line, file.unit) for line in watch.end(state)[1])


def _chunks(chunks: Iterable[Any], said: Said, frequency: float) -> Iterator[Chunk]:
    """Chunks with their instants; those without any follow each other."""
    n_before = 0
    for each in chunks:
        if isinstance(each, Chunk):
            yield each
            continue
        samples = held(each)
        source = records_of(samples, frequency if samples.time is None else None, said.channel, said.unit)
        if len(source.tables) > 1:
            raise DataError(
                f"{source.name}: has {counted(len(source.tables), 'record')}; a chunk of a stream has one"
            )
        channels, times = samples_of(source.tables[0], source.config)
        n_time = next(iter(channels.values())).size
        if times is None or samples.time is None:
            times = (n_before + np.arange(n_time)) / frequency
        else:
            times = times + samples.time.since
        yield Chunk(times, channels)
        n_before += n_time
