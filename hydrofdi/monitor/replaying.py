"""Records that are played as a stream, and its text."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TextIO

from hydrofdi.errors import DataError
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.files import titled
from hydrofdi.records.streams import Chunk

_BLOCK_DURATION = 0.05
"""Time between blocks [s]."""


_MOST_SAMPLES = 4096
"""Samples of a block at most."""


_GAP = 10
"""Sampling periods between records, so that no window holds samples of two."""


def replayed(source: RecordSource, pace: Any, record: str, begin: float | None) -> Iterator[Chunk]:
    """Blocks of samples, each when it is due: lateness is made up for. A short gap is between records."""
    start: float | None = None
    due = 0.0
    for batch, row in _chosen(source, record):
        times = (batch if begin is None else replace(batch, start_time=begin)).time
        begin = float(times[-1]) + _GAP / batch.sampling_frequency
        rate = batch.sampling_frequency if pace is None else pace
        n_block = int(max(1.0, min(_MOST_SAMPLES, rate * _BLOCK_DURATION)))
        for first in range(0, batch.n_time, n_block):
            part = slice(first, first + n_block)
            samples = {channel: values[row, part] for channel, values in batch.channels.items()}
            start, due = start or time.monotonic(), due + times[part].size / rate
            time.sleep(max(0.0, start + due - time.monotonic()))
            yield Chunk(times[part], samples)


def _chosen(source: RecordSource, record: str) -> Iterator[tuple[RecordBatch, int]]:
    number = 0
    reason = ""
    for batch in source.batches():
        reason = next((f"; {rejected.remark.message}" for rejected in batch.rejected), reason)
        for row, record_id in enumerate(batch.record_ids):
            number += 1
            if record in ("", record_id, str(number)):
                for channel in sorted(batch.relative):
                    raise DataError(
                        f"{source.name}: {channel} has no scale, and a stream is in SI; give its 'gain' and"
                        " 'unit' in the description of the files"
                    )
                yield batch, row
                if record:
                    return
    if not number:
        raise DataError(f"{source.name}: contains no records{reason}")
    if record:
        raise DataError(f"{source.name}: has no record {record!r}; it has {number:,}, numbered from 1")


def text_sender(form: str, stream: TextIO) -> Callable[[Chunk], None]:
    """Samples as text, in SI and to the bit: JSON, or CSV with a header that comes again if it changes."""
    written: tuple[Channel, ...] = ()

    def send(chunk: Chunk) -> None:
        nonlocal written
        channels = tuple(chunk.channels)
        rows = zip(chunk.time.tolist(), *(each.tolist() for each in chunk.channels.values()), strict=True)
        if form == "json":
            names = ["time", *(channel.value for channel in channels)]
            finite = ([value if math.isfinite(value) else None for value in row] for row in rows)
            lines = [json.dumps(dict(zip(names, row, strict=True))) for row in finite]
        else:
            titles = [titled("time", "s"), *(titled(each.symbol, each.unit) for each in channels)]
            lines = [] if written == channels else [",".join(titles)]
            lines += [",".join(map(repr, row)) for row in rows]
        written = channels
        stream.writelines(f"{line}\n" for line in lines)
        stream.flush()

    return send
