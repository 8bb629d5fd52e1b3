"""Unscented Kalman filter: prediction and correction of one sample."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.estimation import square_root
from hydrofdi.indicators.estimation.plant import N_STATE, actual, step_of
from hydrofdi.indicators.estimation.prediction import held_of, keep_moving, moving_of
from hydrofdi.indicators.estimation.tuning import FIRST_PARAMETER, N_MEASURED, Places, Tuning
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

GAUSSIAN = 2.0
"""b: weight of the centre, optimal for the fourth moments of a normal distribution."""


@equation
def place_points(mean: Array, root: Array, spread: float, places: Places, points: Array) -> None:
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
    points: Array, places: Places, spread: float, noise: Array, mean: Array, root: Array, rows: Array
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
    square_root.triangularise(rows, 3 * n + 1)
    square_root.take_triangle(rows, root)


class Workspace(NamedTuple):
    """Scratch arrays of a filter: spool path, gain, and sigma points."""

    path: Array
    gain: Array
    points: Array
    rows: Array


def workspace(n: int, n_step: int) -> Workspace:
    """Allocate for n estimated states and `n_step` Runge-Kutta steps per sample."""
    return Workspace(*map(np.zeros, ((2 * n_step + 1,), (n,), (N_STATE, 2 * n + 1), (3 * n + 2, n))))


@equation
def predict_unscented(
    mean: Array, root: Array, spread: float, supply: float, tuning: Tuning, work: Workspace
) -> None:
    """Predict an estimate over one sample, along the spool path in its workspace; supply pressure [MPa]."""
    places, points, path = tuning.places, work.points, work.path
    place_points(mean, root, spread, places, points)
    for i in range(path.size // 2):
        start, middle, end = path[2 * i], path[2 * i + 1], path[2 * i + 2]
        for k in range(points.shape[1]):
            moving, a = moving_of(points[:, k]), actual(held_of(points[:, k]), supply, tuning.plant)
            keep_moving(points[:, k], step_of(moving, tuning.step, start, middle, end, a, tuning.plant))
    gather_points(points, places, spread, tuning.walk, mean, root, work.rows)


@equation
def correct_unscented(
    mean: Array, root: Array, measured: Array, is_open: bool, tuning: Tuning, work: Workspace
) -> float:
    """Correct an estimate by the measurements of a sample; return the sum of normalised squared innovations.

    If the valve is closed, parameters are not updated, as in `ekf.find_gain`.
    """
    total = 0.0
    for k in range(N_MEASURED):
        innovation = measured[k] - mean[k]
        variance = square_root.find_gain(root, k, tuning.sensors[k], work.gain)
        square_root.measurement_update(root, k, tuning.sensors[k] / variance, work.gain)
        for i in range(mean.size):
            if is_open or tuning.places[i] < FIRST_PARAMETER:
                mean[i] += work.gain[i] * innovation
                work.gain[i] = 0.0
            work.gain[i] *= np.sqrt(variance)
        if not is_open:
            square_root.inflate(root, work.gain, work.rows)
        total += innovation * innovation / variance
    return total
