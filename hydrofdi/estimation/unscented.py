"""Square-root unscented transform: propagation of mean and covariance through a model.

P = Σ W δ δᵀ + (b − a²) d dᵀ + Q, where δ is a propagated point minus the propagated centre, d = Σ W δ, and W
= 1 / (2 a² n). This is van der Merwe and Wan's sum, written so that no term is subtracted as long as a² ≤ b:
the root follows from reflections only, without a Cholesky downdate.

Source: van der Merwe & Wan 2001, *The square-root unscented Kalman filter for state and
parameter-estimation*, ICASSP.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.square_root import take_triangle, triangularise
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]
Places = NDArray[np.int64]

GAUSSIAN = 2.0
"""b: weight of the centre, optimal for the fourth moments of a normal distribution."""


@equation
def place_points(mean: Array, root: Array, spread: float, places: Places, points: Array) -> None:
    """Fill sigma points: the mean, and points at ±a √n times each column of S.

    Parameters
    ----------
    mean, root : ndarray, shape (n,), (n, n)
        x and S.
    spread : float
        a, 0 < a² ≤ b.
    places : ndarray of int, shape (n,)
        Rows of `points` that contain the states.
    points : ndarray, shape (at least n, at least 2 n + 1)
        Filled in these rows, one point per column.
    """
    n = places.size
    distance = spread * np.sqrt(n)
    for i in range(n):
        row = places[i]
        points[row, 0] = mean[i]
        for j in range(n):
            way = distance * root[i, j]
            points[row, 1 + j] = mean[i] + way
            points[row, 1 + n + j] = mean[i] - way


@equation
def gather_points(
    points: Array, places: Places, spread: float, noise: Array, mean: Array, root: Array, rows: Array
) -> None:
    """Compute mean and covariance root of propagated points plus process noise.

    Parameters
    ----------
    points : ndarray, shape (at least n, at least 2 n + 1)
        Propagated points, the centre first.
    places : ndarray of int, shape (n,)
    spread : float
        a.
    noise : ndarray, shape (n,)
        Standard deviations of the process noise: roots of the diagonal of Q.
    mean, root : ndarray, shape (n,), (n, n)
        Filled; the root is lower triangular.
    rows : ndarray, shape (at least 3 n + 2, n)
        Scratch.
    """
    n = places.size
    weight = 1.0 / (2.0 * spread * spread * n)
    share, centre = np.sqrt(weight), np.sqrt(GAUSSIAN - spread * spread)
    last = 2 * n
    for i in range(n):
        way, place = 0.0, places[i]
        for j in range(last):
            difference = points[place, 1 + j] - points[place, 0]
            way += difference
            rows[j, i] = share * difference
        way *= weight
        mean[i] = points[place, 0] + way
        rows[last, i] = centre * way
        for j in range(n):
            rows[last + 1 + j, i] = 0.0
        rows[last + 1 + i, i] = noise[i]
    triangularise(rows, 3 * n + 1)
    take_triangle(rows, root)
