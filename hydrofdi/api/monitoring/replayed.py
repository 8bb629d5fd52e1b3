"""Records as a stream: one after the other, at a steady rate."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from hydrofdi.errors import DataError
from hydrofdi.records import Array, RecordBatch, RecordSource
from hydrofdi.records.streams import Chunk

_BLOCK_DURATION = 0.05
"""Time between blocks [s]."""
_MOST_SAMPLES = 4096
"""Samples of a block at most."""
_GAP = 10
"""Sampling periods between records, so that no window holds samples of two."""


class Pace:
    """Waits until samples are due. Lateness is made up for: what follows is not put off.

    Parameters
    ----------
    rate : float or None
        Samples in a second; ``inf`` waits for nothing, None is the rate of each record.
    """

    def __init__(self, rate: float | None) -> None:
        self._rate = rate
        self._start: float | None = None
        self._due = 0.0

    def rate_of(self, sampling_frequency: float) -> float:
        """Samples in a second of a record [Hz]."""
        return sampling_frequency if self._rate is None else self._rate

    def wait(self, n_time: int, rate: float) -> None:
        """Wait until so many samples have come at a rate."""
        if self._start is None:
            self._start = time.monotonic()
        self._due += n_time / rate
        left = self._start + self._due - time.monotonic()
        if left > 0.0:
            time.sleep(left)


def replayed(
    source: RecordSource, pace: Pace, record: str = "", start_time: float | None = None
) -> Iterator[Chunk]:
    """Blocks of samples, each when it is due. Records follow each other with a short gap.

    Parameters
    ----------
    source : RecordSource
    pace : Pace
    record : str
        Name of a record, or its number from 1; all of them where left out.
    start_time : float, optional
        Instant of the first sample [s]; its own where left out.

    Raises
    ------
    DataError
        There is no such record, none at all, or one without a scale.
    """
    begin = start_time
    for batch, row in _chosen(source, record):
        times = (batch if begin is None else replace(batch, start_time=begin)).time
        begin = float(times[-1]) + _GAP / batch.sampling_frequency
        yield from _blocks(batch, row, times, pace)


def _chosen(source: RecordSource, record: str) -> Iterator[tuple[RecordBatch, int]]:
    number = n_chosen = 0
    reason = ""
    for batch in source.batches():
        reason = next((f"; {rejected.remark.text}" for rejected in batch.rejected), reason)
        for row, record_id in enumerate(batch.record_ids):
            number += 1
            if record in ("", record_id, str(number)):
                n_chosen += 1
                _refuse_relative(batch, source.name)
                yield batch, row
    if not number:
        raise DataError(f"{source.name}: contains no records{reason}")
    if not n_chosen:
        raise DataError(f"{source.name}: has no record {record!r}; it has {number:,}, numbered from 1")


def _refuse_relative(batch: RecordBatch, name: str) -> None:
    for channel in sorted(batch.relative):
        raise DataError(
            f"{name}: {channel} has no scale, and a stream is in SI; give its 'gain' and 'unit' in the"
            " description of the files"
        )


def _blocks(batch: RecordBatch, row: int, times: Array, pace: Pace) -> Iterator[Chunk]:
    rate = pace.rate_of(batch.sampling_frequency)
    n_block = int(max(1.0, min(_MOST_SAMPLES, rate * _BLOCK_DURATION)))
    for first in range(0, batch.n_time, n_block):
        part = slice(first, first + n_block)
        block = Chunk(
            times[part], {channel: samples[row, part] for channel, samples in batch.channels.items()}
        )
        pace.wait(block.n_time, rate)
        yield block
