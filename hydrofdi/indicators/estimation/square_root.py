"""Square-root form of covariances, P = S Sᵀ: symmetric and positive semidefinite despite rounding.

Source: Kaminski, Bryson & Schmidt 1971, *Discrete square root filtering: a survey of current techniques*,
IEEE Transactions on Automatic Control 16.
"""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import equation
from hydrofdi.records import Array


@equation
def find_gain(root: Array, k: int, variance: float, gain: Array) -> float:
    """Fill the Kalman gain K of a measurement of state k with variance R; return s = P_kk + R."""
    total = variance
    for j in range(gain.size):
        total += root[k, j] * root[k, j]
    for i in range(gain.size):
        covariance = 0.0
        for j in range(gain.size):
            covariance += root[i, j] * root[k, j]
        gain[i] = covariance / total
    return total


@equation
def measurement_update(root: Array, k: int, ratio: float, gain: Array) -> None:
    """Update a root for a measurement of state k with its gain, in place; `ratio` is R/s.

    S −= K φᵀ/(1 + √(R/s)), where φ is row k of S. Potter's update (Battin 1964, *Astronautical guidance*); no
    eigenvalue of its factor is below √(R/s).
    """
    share = 1.0 / (1.0 + np.sqrt(ratio))
    # Row k is the last one to change, because all others need it.
    for i in range(gain.size):
        if i != k:
            for j in range(gain.size):
                root[i, j] -= share * gain[i] * root[k, j]
    for j in range(gain.size):
        root[k, j] -= share * gain[k] * root[k, j]


@equation
def inflate(root: Array, error: Array, rows: Array) -> None:
    """Add the outer product of a vector to a covariance in place; the root becomes lower triangular.

    With a gain K − e instead of K, the covariance after a measurement increases by s e eᵀ, with `error` √s e;
    `rows` (at least n + 2, n) is scratch.
    """
    n = error.size
    for i in range(n):
        for j in range(n):
            rows[j, i] = root[i, j]
        rows[n, i] = error[i]
    triangularise(rows, n + 1)
    take_triangle(rows, root)


@equation
def take_triangle(rows: Array, root: Array) -> None:
    """Fill a root with the transpose of the triangular matrix in the first rows."""
    for i in range(root.shape[0]):
        for j in range(root.shape[0]):
            root[i, j] = rows[j, i] if j <= i else 0.0


@equation
def triangularise(rows: Array, n_row: int) -> None:
    """Transform rows A by Householder reflections into an upper triangular R with Rᵀ R = Aᵀ A.

    The first n rows become R on and above the diagonal, and scratch below; so is the row after the `n_row` ≥
    n rows of A.
    """
    n = rows.shape[1]
    for k in range(n):
        square = 0.0
        for i in range(k, n_row):
            square += rows[i, k] * rows[i, k]
        if square > 0.0:
            # The sign opposite to the head avoids cancellation in the difference.
            diagonal = -np.copysign(np.sqrt(square), rows[k, k])
            head = rows[k, k] - diagonal
            rows[k, k] = head
            reflect(rows, n_row, k, 1.0 / (diagonal * head))
            rows[k, k] = diagonal


@equation
def reflect(rows: Array, n_row: int, k: int, scale: float) -> None:
    """Add `scale` times v vᵀ A to the columns of A after column k, where v starts on the diagonal."""
    n = rows.shape[1]
    for j in range(k + 1, n):
        rows[n_row, j] = 0.0
    for i in range(k, n_row):
        for j in range(k + 1, n):
            rows[n_row, j] += rows[i, k] * rows[i, j]
    for j in range(k + 1, n):
        rows[n_row, j] *= scale
    for i in range(k, n_row):
        for j in range(k + 1, n):
            rows[i, j] += rows[i, k] * rows[n_row, j]
