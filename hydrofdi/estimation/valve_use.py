"""Samples that determine the flow through the valve, and their supply pressure, as streams."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_LONG_AGO = 1e9
"""Samples since a jump before there was any."""


def new_gate(n_record: int) -> Array:
    """State of `mark_unclear` before the first sample: spool position, and samples since it jumped."""
    return np.tile([0.0, _LONG_AGO], (n_record, 1))


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
    """Mark samples at the start, with the valve hardly open, or soon after its spool jumped.

    Parameters
    ----------
    spool : ndarray, shape (n_record, n_time)
        x_v [m].
    n_before, n_start : int
        Samples of the stream before these, and samples at its start that are left out.
    least_opening : float
        Nearer to its centre the spool is hardly open, or when it passes it [m]; 0 leaves nothing out.
    least_jump : float
        Travel from one sample to the next that is a jump [m].
    n_settling : int
        Samples from a jump on that are left out; the one at which it is seen always is.
    state : ndarray, shape (n_record, 2)
        From `new_gate`; updated in place.
    unclear : ndarray of bool, shape (n_record, n_time)
        Filled.
    """
    n_after = n_settling if n_settling > 1 else 1
    for r in range(spool.shape[0]):
        for i in range(spool.shape[1]):
            x, last = spool[r, i], state[r, 0]
            is_first = n_before + i == 0
            state[r, 0] = x
            state[r, 1] = 0.0 if not is_first and abs(x - last) > least_jump else state[r, 1] + 1.0
            is_closed = abs(x) < least_opening or (not is_first and (x > 0.0) != (last > 0.0))
            is_unclear = n_before + i < n_start or state[r, 1] < n_after
            unclear[r, i] = is_unclear or (least_opening > 0.0 and is_closed)


def new_counts(n_record: int) -> Array:
    """State of `count_windows` before the first sample: unclear samples of this block and the one before."""
    return np.zeros((n_record, 2))


@kernel
def count_windows(unclear: Flags, n_before: int, half: int, state: Array, counts: Array) -> None:
    """Which windows count: those without an unclear sample.

    Parameters
    ----------
    unclear : ndarray of bool, shape (n_record, n_time)
    n_before, half : int
        Samples of the stream before these, and in half a window.
    state : ndarray, shape (n_record, 2)
        From `new_counts`; updated in place.
    counts : ndarray, shape (n_record, n_window)
        Filled with 1 and 0, for the windows that these samples complete.
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
    """State of `follow_means` before the first sample: sum and samples of this block, blocks, mean."""
    return np.tile([0.0, 0.0, 0.0, first], (n_record, 1))


@kernel
def follow_means(
    signal: Array, unclear: Flags, n_before: int, every: int, least_gain: float, state: Array, means: Array
) -> None:
    """Mean of the clear blocks of a signal before each sample, exponential once there are many.

    Parameters
    ----------
    signal : ndarray, shape (n_record, n_time)
    unclear : ndarray of bool, shape (n_record, n_time)
        Samples whose block does not count.
    n_before, every : int
        Samples of the stream before these, and in a block.
    least_gain : float
        Weight of a new block: the larger of this and one over the number of blocks so far.
    state : ndarray, shape (n_record, 4)
        From `new_means`; updated in place.
    means : ndarray, shape (n_record, n_time)
        Filled.
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
