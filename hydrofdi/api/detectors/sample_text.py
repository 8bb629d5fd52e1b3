"""Samples as text, in SI and to the bit."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from hydrofdi.records.written.columns import titled


class CsvText:
    """Rows under a header such as ``time [s],P1 [Pa]``, which comes again where the channels change."""

    def __init__(self) -> None:
        self._channels: Sequence[Channel] = ()

    def __call__(self, chunk: Chunk) -> str:
        """The lines of a block."""
        header = ""
        if self._channels != (channels := tuple(chunk.channels)):
            self._channels = channels
            titles = [titled(channel.symbol, channel.unit) for channel in channels]
            header = ",".join([titled("time", "s"), *titles]) + "\n"
        return header + "".join(f"{','.join(map(repr, row))}\n" for row in _rows(chunk))


class JsonText:
    """A JSON object per sample: ``time`` and channels under their full names; null if one is missing."""

    def __call__(self, chunk: Chunk) -> str:
        """The lines of a block."""
        names = ["time", *(channel.value for channel in chunk.channels)]
        return "".join(
            json.dumps(
                {
                    name: value if math.isfinite(value) else None
                    for name, value in zip(names, row, strict=True)
                }
            )
            + "\n"
            for row in _rows(chunk)
        )


def _rows(chunk: Chunk) -> list[tuple[float, ...]]:
    columns = [chunk.time.tolist(), *(samples.tolist() for samples in chunk.channels.values())]
    return list(zip(*columns, strict=True))
