"""Extended Kalman filter of the nominal plant: P_1, P_2 and x_p are measured, one scalar update each.

Jazwinski, Stochastic Processes and Filtering Theory (1970), section 8.3; updates in the form of Bucy and
Joseph, Filtering for Stochastic Processes (1968), which holds for any gain. The plant's transition leaves the
held states as they are, so that only the rows of the moving states are multiplied.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.plant import N_MOVING, N_STATE
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]

N_MEASURED = 3
"""P_1, P_2 and x_p: the first of the moving states."""

FIRST_PARAMETER = 5
"""Place of the first state that is neither motion nor force."""


@equation
def spread(covariance: Array, transition: Array, walk: Array, rows: Array) -> None:
    """Carry a covariance over a sample, in place.

    Parameters
    ----------
    covariance : ndarray, shape (N_STATE, N_STATE)
    transition : ndarray, shape (N_MOVING, N_STATE)
        How the moving states depend on all of them.
    walk : ndarray, shape (N_STATE,)
        Variance that the sample adds to each state.
    rows : ndarray, shape (N_MOVING, N_STATE)
        Workspace.
    """
    for m in range(N_MOVING):
        for j in range(N_STATE):
            rows[m, j] = 0.0
        for k in range(N_STATE):
            share = transition[m, k]
            for j in range(N_STATE):
                rows[m, j] += share * covariance[k, j]
    for m in range(N_MOVING):
        for j in range(N_MOVING, N_STATE):
            covariance[m, j] = covariance[j, m] = rows[m, j]
        for n in range(m + 1):
            total = 0.0
            for k in range(N_STATE):
                total += rows[m, k] * transition[n, k]
            covariance[m, n] = covariance[n, m] = total
    for j in range(N_STATE):
        covariance[j, j] += walk[j]


@equation
def find_gain(covariance: Array, place: int, total: float, is_trusted: bool, gain: Array) -> None:
    """Fill the gain of a measurement of one state with a variance of the innovation in all.

    Where it is not trusted, parameters do not learn from it and are considered with their variances alone;
    Schmidt, Advances in Control Systems 3 (1966).
    """
    for j in range(N_STATE):
        gain[j] = covariance[place, j] / total
    if not is_trusted:
        for j in range(FIRST_PARAMETER, N_STATE):
            gain[j] = 0.0


@equation
def learn(covariance: Array, place: int, total: float, gain: Array, row: Array) -> None:
    """What a covariance P is after a measurement of one state i with any gain K, in place.

    (1 − K e_iᵀ) P (1 − K e_iᵀ)ᵀ + r K Kᵀ = P − K p − (p − s K) Kᵀ with p the row i of P and s = P_ii + r.

    Parameters
    ----------
    covariance : ndarray, shape (N_STATE, N_STATE)
    place : int
        i
    total : float
        s
    gain : ndarray, shape (N_STATE,)
        K
    row : ndarray, shape (N_STATE,)
        Workspace.
    """
    for j in range(N_STATE):
        row[j] = covariance[place, j]
    for i in range(N_STATE):
        rest = row[i] - total * gain[i]
        for j in range(N_STATE):
            covariance[i, j] -= gain[i] * row[j] + rest * gain[j]


@equation
def make_symmetric(matrix: Array) -> None:
    """Replace a square matrix by its mean with its transpose."""
    for i in range(N_STATE):
        for j in range(i):
            matrix[i, j] = matrix[j, i] = 0.5 * (matrix[i, j] + matrix[j, i])


@equation
def is_sound(mean: Array, covariance: Array, limits: Array) -> bool:
    """Whether all estimates are within physical limits, and no variance is negative; NaN is neither."""
    sound = True
    for j in range(N_STATE):
        sound &= abs(mean[j]) <= limits[j]
        sound &= 0.0 <= covariance[j, j] < np.inf
    return sound
