"""Recursive weak form of the volume balance: from samples to equations of overlapping windows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.estimation.chamber_balance import (
    N_OWN,
    N_SHARED,
    N_UNKNOWN,
    Balance,
    valve_signals,
    write_equation,
)
from hydrofdi.physics.equation import equation
from hydrofdi.physics.signed_root import signed_root

Array = NDArray[np.float64]

CURRENT, ENDING, BEFORE = 0, 1, 2
"""Rows of sums: current block as first and as second half of a window, and previous block."""


def new_sums(n_record: int, n_chamber: int) -> Array:
    """State of `integrate_windows` before the first sample."""
    return np.zeros((n_record, 3, N_SHARED + n_chamber * N_OWN))


def windows_before(n_sample: int, half: int) -> int:
    """Number of windows that are complete after `n_sample` samples of a stream."""
    return max(n_sample // half - 1, 0)


@equation
def add(sums: Any, place: int, signal: float, first: float, second: float) -> None:
    """Add a weighted sample to the windows that start and end with this block."""
    sums[CURRENT, place] += first * signal
    sums[ENDING, place] += second * signal


@kernel
def integrate_windows(
    spool: Array,
    position: Array,
    pressures: Array,
    supply: Array,
    reference: Array,
    weights: Array,
    n_before: int,
    balance: Balance,
    sums: Array,
    columns: Array,
    targets: Array,
) -> None:
    """Fill the equations of the windows that these samples complete.

    Parameters
    ----------
    spool, position : ndarray, shape (n_record, n_time)
        x_v and x_p [m].
    pressures : ndarray, shape (2, n_record, n_time)
        P_1 and P_2 [Pa].
    supply, reference : ndarray, shape (n_record, n_time)
        P_s at the linearisation point, and the reference of its prior deviation [Pa].
    weights : ndarray, shape (2, 3, half)
        Weights of the samples in the first and second half of a window, for ∫ φ s, ∫ φ s' and ∫ φ τ s'.
    n_before : int
        Samples of the stream before these.
    balance : Balance
    sums : ndarray, shape (n_record, 3, N_SHARED + n_chamber N_OWN)
        State of each stream, from `new_sums`; updated in place.
    columns : ndarray, shape (n_record, n_window, n_chamber, N_UNKNOWN)
        Filled.
    targets : ndarray, shape (n_record, n_window, n_chamber)
        Filled [m³].
    """
    n_record, n_time = spool.shape
    half, n_sum, n_chamber = weights.shape[2], sums.shape[2], targets.shape[2]
    for r in range(n_record):
        own = sums[r]
        n_window = 0
        for i in range(n_time):
            j = (n_before + i) % half
            if j == 0:
                for k in range(n_sum):
                    own[CURRENT, k] = own[ENDING, k] = 0.0
            first, second = weights[0, 0, j], weights[1, 0, j]
            x, x_v, p_1 = position[r, i], spool[r, i], pressures[0, r, i]
            add(own, 0, x, first, second)
            add(own, 1, signed_root(p_1 - pressures[1, r, i]), first, second)
            add(own, 2, x, weights[0, 1, j], weights[1, 1, j])
            for chamber in range(n_chamber):
                sign, k = 1.0 if chamber == 0 else -1.0, N_SHARED + chamber * N_OWN
                p = pressures[chamber, r, i]
                signals = valve_signals(
                    x_v, p, supply[r, i], reference[r, i], balance.return_pressure, balance.gain, sign
                )
                add(own, k, signals.flow, first, second)
                add(own, k + 1, signals.by_supply, first, second)
                add(own, k + 2, signals.supply_error, first, second)
                add(own, k + 3, signals.by_offset, first, second)
                add(own, k + 4, signals.by_lap, first, second)
                add(own, k + 5, signals.by_clearance, first, second)
                add(own, k + 6, signals.by_fed, first, second)
                add(own, k + 7, signals.by_drained, first, second)
                add(own, k + 8, p, weights[0, 1, j], weights[1, 1, j])
                add(own, k + 9, p, weights[0, 2, j], weights[1, 2, j])
            if j == half - 1:
                if n_before + i >= half:
                    for k in range(n_sum):
                        own[BEFORE, k] += own[ENDING, k]
                    for chamber in range(n_chamber):
                        place = N_SHARED + chamber * N_OWN
                        targets[r, n_window, chamber] = write_equation(
                            own[BEFORE, place:], chamber, balance, own[BEFORE, 0], own[BEFORE, 1],
                            own[BEFORE, 2], columns[r, n_window, chamber],
                        )  # fmt: skip
                    n_window += 1
                for k in range(n_sum):
                    own[BEFORE, k] = own[CURRENT, k]


def window_equations(
    spool: Array,
    position: Array,
    pressures: Array,
    supply: Array,
    reference: Array,
    weights: Array,
    n_before: int,
    balance: Balance,
    sums: Array,
) -> tuple[Array, Array]:
    """Regressors and targets of `integrate_windows`; the state is updated in place."""
    n_record, n_time = spool.shape
    half, n_chamber = weights.shape[2], (sums.shape[2] - N_SHARED) // N_OWN
    n_window = windows_before(n_before + n_time, half) - windows_before(n_before, half)
    columns = np.zeros((n_record, n_window, n_chamber, N_UNKNOWN))
    targets = np.zeros((n_record, n_window, n_chamber))
    integrate_windows(
        spool, position, pressures, supply, reference, weights, n_before, balance, sums, columns, targets
    )
    return columns, targets
