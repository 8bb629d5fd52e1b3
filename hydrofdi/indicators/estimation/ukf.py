"""Unscented Kalman filter: prediction and correction of one sample.

The covariance has square-root form, P = S Sᵀ: symmetric and positive semidefinite despite rounding. Source:
Kaminski, Bryson & Schmidt 1971, *Discrete square root filtering: a survey of current techniques*, IEEE
Transactions on Automatic Control 16.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.estimation import plant
from hydrofdi.indicators.estimation.ekf import held_of, keep_moving, moving_of
from hydrofdi.physics import equation
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


GAUSSIAN = 2.0
"""b: weight of the centre, optimal for the fourth moments of a normal distribution."""


@equation
def place_points(mean: Array, root: Array, spread: float, places: plant.Places, points: Array) -> None:
    """Fill sigma points in the rows `places`: the mean, and points at ±a √n times each column of S.

    One point per column, a is the spread, 0 < a² ≤ b.
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
    points: Array, places: plant.Places, spread: float, noise: Array, mean: Array, root: Array, rows: Array
) -> None:
    """Compute mean and covariance root of propagated points plus process noise.

    `points` as from `place_points`, the centre first; `noise`: roots of the diagonal of Q; the root becomes
    lower triangular; `rows` (at least 3 n + 2, n) is scratch.
    """
    n = places.size
    weight = 1.0 / (2.0 * spread * spread * n)
    # The weight of the centre is split off, so that all weights under a root are positive.
    share, centre = np.sqrt(weight), np.sqrt(GAUSSIAN - spread * spread)
    last = 2 * n
    for i in range(n):
        way, row = 0.0, places[i]
        for j in range(last):
            difference = points[row, 1 + j] - points[row, 0]
            way += difference
            rows[j, i] = share * difference
        way *= weight
        mean[i] = points[row, 0] + way
        rows[last, i] = centre * way
        for j in range(n):
            rows[last + 1 + j, i] = 0.0
        rows[last + 1 + i, i] = noise[i]
    triangularise(rows, 3 * n + 1)
    take_triangle(rows, root)


class Workspace(NamedTuple):
    """Scratch arrays of a filter: spool path, gain, and sigma points."""

    path: Array
    gain: Array
    points: Array
    rows: Array


def workspace(n: int, n_step: int) -> Workspace:
    """Allocate for n estimated states and `n_step` Runge-Kutta steps per sample."""
    return Workspace(*map(np.zeros, ((2 * n_step + 1,), (n,), (plant.N_STATE, 2 * n + 1), (3 * n + 2, n))))


@equation
def predict_unscented(
    mean: Array, root: Array, spread: float, supply: float, tuning: plant.Tuning, work: Workspace
) -> None:
    """Predict an estimate over one sample, along the spool path in its workspace; supply pressure [MPa]."""
    places, points, path = tuning.places, work.points, work.path
    place_points(mean, root, spread, places, points)
    for i in range(path.size // 2):
        start, middle, end = path[2 * i], path[2 * i + 1], path[2 * i + 2]
        for k in range(points.shape[1]):
            moving, a = moving_of(points[:, k]), plant.actual(held_of(points[:, k]), supply, tuning.plant)
            keep_moving(points[:, k], plant.step_of(moving, tuning.step, start, middle, end, a, tuning.plant))
    gather_points(points, places, spread, tuning.walk, mean, root, work.rows)


@equation
def correct_unscented(
    mean: Array, root: Array, measured: Array, is_open: bool, tuning: plant.Tuning, work: Workspace
) -> float:
    """Correct an estimate by the measurements of a sample; return the sum of normalised squared innovations.

    If the valve is closed, parameters are not updated, as in `ekf.find_gain`.
    """
    total = 0.0
    for k in range(plant.N_MEASURED):
        innovation = measured[k] - mean[k]
        variance = find_gain(root, k, tuning.sensors[k], work.gain)
        measurement_update(root, k, tuning.sensors[k] / variance, work.gain)
        for i in range(mean.size):
            if is_open or tuning.places[i] < plant.FIRST_PARAMETER:
                mean[i] += work.gain[i] * innovation
                work.gain[i] = 0.0
            work.gain[i] *= np.sqrt(variance)
        if not is_open:
            inflate(root, work.gain, work.rows)
        total += innovation * innovation / variance
    return total
