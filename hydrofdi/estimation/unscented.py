"""Sigma points, and their prediction through the equations of the plant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.plant import N_STATE, Held, Moving, Plant, actual, step_of
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


class Estimated(NamedTuple):
    """Estimated states and their random walks.

    Attributes
    ----------
    places : ndarray of int, shape (n,)
        Indices of the estimated states in ``STATES``, moving states first; all other states are zero.
    walk : ndarray, shape (n,)
        Standard deviations of their random walks per sample, in their units.
    spread : float
        Spread a of the sigma points, in √n standard deviations.
    """

    places: Places
    walk: Array
    spread: float


class Workspace(NamedTuple):
    """Arrays of a filter: estimate, gain, spool path and sigma points."""

    mean: Array
    root: Array
    gain: Array
    path: Array
    points: Array
    rows: Array

    @classmethod
    def of(cls, n: int, n_step: int) -> Workspace:
        """Allocate for n estimated states and `n_step` Runge-Kutta steps per sample."""
        shapes = (n,), (n, n), (n,), (2 * n_step + 1,), (N_STATE, 2 * n + 1), (3 * n + 2, n)
        return cls(*map(np.zeros, shapes))


@equation
def predict_unscented(
    step: float, supply: float, estimated: Estimated, plant: Plant, work: Workspace
) -> None:
    """Predict the estimate in a workspace over one sample, along its spool path.

    Parameters
    ----------
    step : float
        Runge-Kutta step [s].
    supply : float
        Nominal or measured supply pressure [MPa].
    estimated : Estimated
    plant : Plant
    work : Workspace
    """
    points, path = work.points, work.path
    place_points(work.mean, work.root, estimated.spread, estimated.places, points)
    for i in range(path.size // 2):
        move(points, step, path[2 * i], path[2 * i + 1], path[2 * i + 2], supply, plant)
    gather_points(points, estimated.places, estimated.spread, estimated.walk, work.mean, work.root, work.rows)


@equation
def move(
    points: Array, step: float, start: float, middle: float, end: float, supply: float, plant: Plant
) -> None:
    """Advance points by one Runge-Kutta step."""
    for k in range(points.shape[1]):
        moving, held = moving_at(points, k), held_at(points, k)
        moving = step_of(moving, step, start, middle, end, actual(held, supply, plant), plant)
        points[0, k], points[1, k] = moving.pressure_1, moving.pressure_2
        points[2, k], points[3, k] = moving.position, moving.velocity


@equation
def moving_at(points: Array, k: int) -> Moving:
    """Moving states of a point."""
    return Moving(points[0, k], points[1, k], points[2, k], points[3, k])


@equation
def held_at(points: Array, k: int) -> Held:
    """Held states of a point."""
    return Held(
        points[4, k], points[5, k], points[6, k], points[7, k],
        points[8, k], points[9, k], points[10, k], points[11, k],
        points[12, k], points[13, k],
    )  # fmt: skip
