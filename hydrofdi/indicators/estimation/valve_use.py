"""Samples and windows with information, and running means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.records import Array
from hydrofdi.settings.quantities import BELOW

Flags = NDArray[np.bool_]


def unclear_samples(spool: Array, jumps: Flags, n_settling: int, least_opening: float) -> Flags:
    """Samples soon after a jump of the spool, or with the valve almost closed, (n_record, n_time).

    `n_settling` samples from a jump on, at least the one that shows it, are unclear. The valve is almost
    closed within `least_opening` of its centre, and where it crosses it; 0 excludes nothing.
    """
    n_after, so_far = max(n_settling, 1), np.cumsum(jumps, axis=1, dtype=np.intp)
    so_far[:, n_after:] -= so_far[:, :-n_after].copy()
    unclear: Flags = so_far > 0
    if least_opening > 0.0:
        unclear |= np.abs(spool) < BELOW * least_opening
        unclear[:, 1:] |= (spool[:, 1:] > 0.0) != (spool[:, :-1] > 0.0)
    return unclear


def clear_windows(unclear: Flags, half: int) -> Array:
    """1 for each window (n_record, n_window) without an unclear sample, else 0."""
    n_block = unclear.shape[1] // half
    blocks = unclear[:, : n_block * half].reshape(len(unclear), n_block, half)
    in_block: Flags = np.logical_or.reduce(blocks, axis=2)
    return np.asarray(~(in_block[:, :-1] | in_block[:, 1:]), dtype=float)


@kernel
def follow_means(
    signal: Array, unclear: Flags, every: int, least_gain: float, first: float, means: Array
) -> None:
    """Fill the mean of the clear blocks of a signal before each sample, with exponential forgetting.

    Signal, `unclear` and `means` (n_record, n_time); a block of `every` samples with an unclear one is
    excluded. The weight of a new block is at least `least_gain`; before it is reached, one over the number of
    blocks. The mean before the first block is `first`.
    """
    for r in range(signal.shape[0]):
        total, n_clear, n_block, mean = 0.0, 0.0, 0.0, first
        for i in range(signal.shape[1]):
            means[r, i] = mean
            total += signal[r, i]
            n_clear += 0.0 if unclear[r, i] else 1.0
            if i % every == every - 1:
                if n_clear == every:
                    n_block += 1.0
                    gain = 1.0 / n_block if least_gain * n_block < 1.0 else least_gain
                    mean += gain * (total / every - mean)
                total = n_clear = 0.0
