"""Records as streams."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

from hydrofdi.api.arguments import names_of, positive_of
from hydrofdi.api.records.columns import Names
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.errors import DataError
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.streams import Chunk

_BLOCK_DURATION = 0.05
"""Time between blocks [s]."""
_MOST_SAMPLES = 4096
"""Samples of a block at most."""
_GAP = 10
"""Sampling periods between records, so that no window holds samples of two."""


def replay(
    data: Any,
    *,
    rate: str | float | None = "max",
    record: str = "",
    now: bool = False,
    settings: Sequence[str] = (),
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> Iterator[Chunk]:
    """Play records as a stream, for trying a detector out.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. They follow each other with a short gap.
    rate : str or float, optional
        Samples in a second, such as ``"500 Hz"``; ``"max"``, as fast as they are taken; None, as measured.
    record : str, optional
        Replay only one record: its number, from 1, or its name.
    now : bool
        Start time at the present, in seconds since 1970.
    settings : sequence of str, optional
        ``KEY=VALUE`` of an experiment that is simulated.
    sampling_frequency, channel, unit
        Of records in memory, as in `hydrofdi.measure`.

    Yields
    ------
    Chunk
        Up to 4,096 samples, ``time`` [s] and ``channels`` in SI; `Detector.watch` takes them.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> chunks = list(hydrofdi.replay(numpy.zeros(1000), sampling_frequency="1 kHz"))
    >>> sum(chunk.n_time for chunk in chunks)
    1000
    """
    pace = Pace(_rate(rate))
    (chosen,) = names_of("record", record, "the number or name of a record") if record != "" else [""]
    stated = names_of("settings", settings, "texts such as 'fluid.bulk_modulus=689 MPa'")
    sources = sources_of(data, tuple(Channel), Said(sampling_frequency, channel, unit, settings=stated))
    start = time.time() if now else None
    return chain.from_iterable(replayed(source, pace, chosen, start) for source in sources)


def _rate(given: str | float | None) -> float | None:
    """Samples in a second; None for the rate of the record."""
    if given is None or given == "max":
        return None if given is None else math.inf
    return positive_of("rate", given, "Hz", "a number in Hz, a text such as '500 Hz', or 'max'")


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
    """Blocks of samples, each when it is due. Records follow each other with a short gap."""
    begin = start_time
    for batch, row in _chosen(source, record):
        times = (batch if begin is None else replace(batch, start_time=begin)).time
        begin = float(times[-1]) + _GAP / batch.sampling_frequency
        yield from _blocks(batch, row, times, pace)


def _chosen(source: RecordSource, record: str) -> Iterator[tuple[RecordBatch, int]]:
    number = n_chosen = 0
    reason = ""
    for batch in source.batches():
        reason = next((f"; {rejected.remark.message}" for rejected in batch.rejected), reason)
        for row, record_id in enumerate(batch.record_ids):
            number += 1
            if record in ("", record_id, str(number)):
                n_chosen += 1
                for channel in sorted(batch.relative):
                    raise DataError(
                        f"{source.name}: {channel} has no scale, and a stream is in SI; give its 'gain' and"
                        " 'unit' in the description of the files"
                    )
                yield batch, row
    if not number:
        raise DataError(f"{source.name}: contains no records{reason}")
    if not n_chosen:
        raise DataError(f"{source.name}: has no record {record!r}; it has {number:,}, numbered from 1")


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
