"""Prediction of sigma points with the nominal plant, in parallel SIMD lanes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.plant import N_STATE, Held, Moving, Plant, actual, step_of
from hydrofdi.estimation.unscented import gather_points, place_points
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]
Places = NDArray[np.int64]


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
