"""Extended Kalman filter of the nominal plant, with scalar updates by P_1, P_2 and x_p.

Jazwinski, Stochastic Processes and Filtering Theory (1970), section 8.3; updates in the form of Bucy and
Joseph, Filtering for Stochastic Processes (1968), which is valid for any gain. The transition does not change
the held states, so only the rows of the moving states are multiplied.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.plant import N_MOVING, N_STATE
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]

N_MEASURED = 3
"""Number of measurements: P_1, P_2 and x_p, the first of the moving states."""

FIRST_PARAMETER = 5
"""Index of the first state that is neither motion nor force."""


@equation
def spread(covariance: Array, transition: Array, walk: Array, rows: Array) -> None:
    """Propagate a covariance over one sample, in place.

    Parameters
    ----------
    covariance : ndarray, shape (N_STATE, N_STATE)
    transition : ndarray, shape (N_MOVING, N_STATE)
        Derivatives of the moving states by all states.
    walk : ndarray, shape (N_STATE,)
        Process noise variance of each state per sample.
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
    """Fill the Kalman gain of a measurement of one state, given the total innovation variance.

    If the measurement is not trusted, the gain of parameters is zero: only their variances are considered,
    Schmidt, Advances in Control Systems 3 (1966).
    """
    for j in range(N_STATE):
        gain[j] = covariance[place, j] / total
    if not is_trusted:
        for j in range(FIRST_PARAMETER, N_STATE):
            gain[j] = 0.0


@equation
def learn(covariance: Array, place: int, total: float, gain: Array, row: Array) -> None:
    """Update a covariance P for a measurement of state i with any gain K, in place.

    (1 − K e_iᵀ) P (1 − K e_iᵀ)ᵀ + r K Kᵀ = P − K p − (p − s K) Kᵀ with p = row i of P and s = P_ii + r.

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
    """Symmetrise a square matrix in place: mean with its transpose."""
    for i in range(N_STATE):
        for j in range(i):
            matrix[i, j] = matrix[j, i] = 0.5 * (matrix[i, j] + matrix[j, i])


@equation
def is_sound(mean: Array, covariance: Array, limits: Array) -> bool:
    """Whether all estimates are within physical limits and no variance is negative; false for NaN."""
    sound = True
    for j in range(N_STATE):
        sound &= abs(mean[j]) <= limits[j]
        sound &= 0.0 <= covariance[j, j] < np.inf
    return sound
