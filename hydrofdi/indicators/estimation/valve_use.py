"""Samples and windows with information, and running means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.records import Array
from hydrofdi.settings.quantities import ABOVE, BELOW

Flags = NDArray[np.bool_]

_NO_JUMP_YET = 1e9
"""Number of samples since the last jump, before the first jump."""


@kernel
def mark_unclear(
    spool: Array, n_start: int, least_opening: float, least_jump: float, n_settling: int, unclear: Flags
) -> None:
    """Mark samples at the start, with the valve almost closed, or soon after a jump of the spool.

    `spool` and `unclear` (n_record, n_time); the first `n_start` samples are excluded. The valve is almost
    closed within `least_opening` of its centre, and where it crosses it; 0 excludes nothing. A jump
    is a travel above `least_jump` between two samples [m]; `n_settling` samples from it on, at least the one
    that shows it, are excluded.
    """
    n_after = n_settling if n_settling > 1 else 1
    for r in range(spool.shape[0]):
        last, since_jump = spool[r, 0], _NO_JUMP_YET
        for i in range(spool.shape[1]):
            x = spool[r, i]
            since_jump = 0.0 if abs(x - last) > ABOVE * least_jump else since_jump + 1.0
            is_closed = abs(x) < BELOW * least_opening or (x > 0.0) != (last > 0.0)
            is_unclear = i < n_start or since_jump < n_after
            last = x
            unclear[r, i] = is_unclear or (least_opening > 0.0 and is_closed)


@kernel
def count_windows(unclear: Flags, half: int, counts: Array) -> None:
    """Fill 1 for each window (n_record, n_window) without an unclear sample, else 0."""
    for r in range(counts.shape[0]):
        for window in range(counts.shape[1]):
            counts[r, window] = 1.0
            for i in range(window * half, (window + 2) * half):
                if unclear[r, i]:
                    counts[r, window] = 0.0


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
