"""The beginning of a stream, to recognise the stream if it is sent again."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk, State

_NONE = np.zeros(2, dtype=np.int64)


class Beginning:
    """Checksums of the first samples of this run and of the previous run.

    Parameters
    ----------
    channels : sequence of Channel
    n_sample : int
        Number of samples of a beginning.
    """

    def __init__(self, channels: Sequence[Channel], n_sample: int) -> None:
        self.channels, self.n_sample = tuple(channels), n_sample

    def start(self) -> State:
        """The state before the first sample: for each run, a checksum and the number of its samples."""
        return {"begin": _NONE, "begin_before": _NONE}

    def resumed(self, state: State) -> State:
        """The state of a stream that may be sent again."""
        is_whole = state["begin"][1] == self.n_sample
        return {"begin": _NONE, "begin_before": state["begin" if is_whole else "begin_before"]}

    def step(self, state: State, chunk: Chunk) -> State:
        """The state after a chunk."""
        checksum, n_before = state["begin"].tolist()
        if n_before == self.n_sample:
            return {name: state[name] for name in ("begin", "begin_before")}
        some = slice(self.n_sample - n_before)
        missing = np.full(chunk.n_time, np.nan)
        rows = [chunk.time, *(chunk.channels.get(channel, missing) for channel in self.channels)]
        samples = np.column_stack([row[some] for row in rows])
        begin: NDArray[np.int64] = np.array(
            [zlib.crc32(samples.tobytes(), checksum), n_before + len(samples)]
        )
        return {"begin": begin, "begin_before": state["begin_before"]}

    def comes_again(self, state: State) -> bool:
        """Whether this run began like the previous one; False while that is unknown."""
        return bool(state["begin"][1] == self.n_sample and np.all(state["begin"] == state["begin_before"]))
