"""Samples and windows with information, and running means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.records import Array
from hydrofdi.units import ABOVE, BELOW

Flags = NDArray[np.bool_]

_NO_JUMP_YET = 1e9
"""Number of samples since the last jump, before the first jump."""


def new_gate(n_record: int) -> Array:
    """State of `mark_unclear` before the first sample: spool position, and samples since its last jump."""
    return np.tile([0.0, _NO_JUMP_YET], (n_record, 1))


@kernel
def mark_unclear(
    spool: Array,
    n_before: int,
    n_start: int,
    least_opening: float,
    least_jump: float,
    n_settling: int,
    state: Array,
    unclear: Flags,
) -> None:
    """Mark samples at the start, with the valve almost closed, or soon after a jump of the spool.

    `spool` and `unclear` (n_record, n_time); the first `n_start` samples of a stream, of which `n_before`
    came before these, are excluded. The valve is almost closed within `least_opening` of its centre, and
    where it crosses it; 0 excludes nothing. A jump is a travel above `least_jump` between two samples [m];
    `n_settling` samples from it on, at least the one that shows it, are excluded. The state is that of
    `new_gate`.
    """
    n_after = n_settling if n_settling > 1 else 1
    for r in range(spool.shape[0]):
        for i in range(spool.shape[1]):
            x, last = spool[r, i], state[r, 0]
            is_first = n_before + i == 0
            state[r, 0] = x
            state[r, 1] = 0.0 if not is_first and abs(x - last) > ABOVE * least_jump else state[r, 1] + 1.0
            is_closed = abs(x) < BELOW * least_opening or (not is_first and (x > 0.0) != (last > 0.0))
            is_unclear = n_before + i < n_start or state[r, 1] < n_after
            unclear[r, i] = is_unclear or (least_opening > 0.0 and is_closed)


def new_counts(n_record: int) -> Array:
    """Initial state of `count_windows`: unclear samples in the current and the previous block."""
    return np.zeros((n_record, 2))


@kernel
def count_windows(unclear: Flags, n_before: int, half: int, state: Array, counts: Array) -> None:
    """Fill 1 for each window (n_record, n_window) that these samples complete without an unclear one.

    Else 0; the state from `new_counts` is updated in place.
    """
    for r in range(unclear.shape[0]):
        n_window = 0
        for i in range(unclear.shape[1]):
            j = (n_before + i) % half
            if j == 0:
                state[r, 1] = state[r, 0]
                state[r, 0] = 0.0
            if unclear[r, i]:
                state[r, 0] += 1.0
            if j == half - 1 and n_before + i >= half:
                counts[r, n_window] = 1.0 if state[r, 0] + state[r, 1] == 0.0 else 0.0
                n_window += 1


def new_means(n_record: int, first: float) -> Array:
    """Initial state of `follow_means`: sum and samples of the current block, number of blocks, mean."""
    return np.tile([0.0, 0.0, 0.0, first], (n_record, 1))


@kernel
def follow_means(
    signal: Array, unclear: Flags, n_before: int, every: int, least_gain: float, state: Array, means: Array
) -> None:
    """Fill the mean of the clear blocks of a signal before each sample, with exponential forgetting.

    Signal, `unclear` and `means` (n_record, n_time); a block of `every` samples with an unclear one is
    excluded. The weight of a new block is at least `least_gain`; before it is reached, one over the number of
    blocks. The state from `new_means` is updated in place.
    """
    for r in range(signal.shape[0]):
        for i in range(signal.shape[1]):
            means[r, i] = state[r, 3]
            state[r, 0] += signal[r, i]
            state[r, 1] += 0.0 if unclear[r, i] else 1.0
            if (n_before + i) % every == every - 1:
                if state[r, 1] == every:
                    state[r, 2] += 1.0
                    gain = 1.0 / state[r, 2] if least_gain * state[r, 2] < 1.0 else least_gain
                    state[r, 3] += gain * (state[r, 0] / every - state[r, 3])
                state[r, 0] = state[r, 1] = 0.0
