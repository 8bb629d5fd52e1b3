"""Prediction of the nominal plant over one sample, and its state transition matrix.

The transition matrix is the exact derivative of the Runge-Kutta steps, propagated through every stage.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.plant import (
    N_MOVING,
    N_STATE,
    Held,
    Moving,
    Plant,
    actual,
    mean_rates,
    moved,
    rates,
    step_of,
)
from hydrofdi.estimation.slopes import Slopes, slopes
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]

TANGENT_SHAPE = (4, N_MOVING, N_STATE)
"""Shape of the workspace of `advance_with_transition`."""


@equation
def moving_of(state: Array) -> Moving:
    """Moving states of a state vector."""
    return Moving(state[0], state[1], state[2], state[3])


@equation
def held_of(state: Array) -> Held:
    """Held states of a state vector."""
    return Held(
        state[4], state[5], state[6], state[7], state[8], state[9], state[10], state[11], state[12], state[13]
    )


@equation
def keep_moving(state: Array, moving: Moving) -> None:
    """Write the moving states into a state vector."""
    state[0], state[1] = moving.pressure_1, moving.pressure_2
    state[2], state[3] = moving.position, moving.velocity


@equation
def advance(state: Array, path: Array, step: float, supply: float, plant: Plant) -> None:
    """Advance a state by one sample, in place.

    Parameters
    ----------
    state : ndarray, shape (N_STATE,)
        In the order of ``STATES``.
    path : ndarray, shape (2 n_step + 1,)
        Spool position at the starts, middles and end of the Runge-Kutta steps [mm].
    step : float
        Runge-Kutta step [s].
    supply : float
        Nominal or measured supply pressure [MPa].
    plant : Plant
    """
    moving, a = moving_of(state), actual(held_of(state), supply, plant)
    for i in range(path.size // 2):
        moving = step_of(moving, step, path[2 * i], path[2 * i + 1], path[2 * i + 2], a, plant)
    keep_moving(state, moving)


@equation
def advance_with_transition(
    state: Array, path: Array, step: float, supply: float, plant: Plant, transition: Array, tangents: Array
) -> None:
    """`advance`, and the derivatives of the moving states at the end by all states at the start.

    Parameters
    ----------
    state, path, step, supply, plant
        As for `advance`.
    transition : ndarray, shape (N_MOVING, N_STATE)
        Filled with ∂(moving states at the end)/∂(states at the start); the held states do not change.
    tangents : ndarray, shape TANGENT_SHAPE
        Workspace.
    """
    moving, a = moving_of(state), actual(held_of(state), supply, plant)
    for i in range(N_MOVING):
        for j in range(N_STATE):
            transition[i, j] = 1.0 if i == j else 0.0
    stage, half = tangents[3], 0.5 * step
    for i in range(path.size // 2):
        start, middle, end = path[2 * i], path[2 * i + 1], path[2 * i + 2]
        first = rates(moving, start, a, plant)
        drive(transition, slopes(moving, start, a, plant), plant, tangents[0])
        at_second = moved(moving, half, first)
        second = rates(at_second, middle, a, plant)
        go(transition, half, tangents[0], stage)
        drive(stage, slopes(at_second, middle, a, plant), plant, tangents[1])
        at_third = moved(moving, half, second)
        third = rates(at_third, middle, a, plant)
        go(transition, half, tangents[1], stage)
        drive(stage, slopes(at_third, middle, a, plant), plant, tangents[2])
        at_fourth = moved(moving, step, third)
        fourth = rates(at_fourth, end, a, plant)
        go(transition, step, tangents[2], stage)
        for m in range(N_MOVING):
            for j in range(N_STATE):
                tangents[0, m, j] += 2.0 * (tangents[1, m, j] + tangents[2, m, j])
        drive(stage, slopes(at_fourth, end, a, plant), plant, tangents[1])
        go(transition, step / 6.0, tangents[0], transition)
        go(transition, step / 6.0, tangents[1], transition)
        moving = moved(moving, step, mean_rates(first, second, third, fourth))
    keep_moving(state, moving)


@equation
def go(tangent: Array, time: float, along: Array, result: Array) -> None:
    """Advance a tangent with constant rates for a time."""
    for m in range(N_MOVING):
        for j in range(N_STATE):
            result[m, j] = tangent[m, j] + time * along[m, j]


@equation
def drive(tangent: Array, s: Slopes, plant: Plant, result: Array) -> None:
    """Rates of a tangent: the Jacobian of the plant times the tangent."""
    one, two, by_mass = s.chamber_1, s.chamber_2, 1.0 / plant.mass
    for j in range(N_STATE):
        p_1, p_2, x, v = tangent[0, j], tangent[1, j], tangent[2, j], tangent[3, j]
        result[0, j] = one.pressure_1 * p_1 + one.pressure_2 * p_2 + one.position * x + one.velocity * v
        result[1, j] = two.pressure_1 * p_1 + two.pressure_2 * p_2 + two.position * x + two.velocity * v
        result[2, j] = v
        force = plant.area_1 * p_1 - plant.area_2 * p_2 - plant.stiffness * x - s.friction * v
        result[3, j] = by_mass * force
    result[3, 4] -= by_mass
    result[0, 5] += one.leakage
    result[1, 5] += two.leakage
    result[0, 6] += one.bulk_modulus
    result[1, 6] += two.bulk_modulus
    result[0, 7] += one.supply
    result[1, 7] += two.supply
    result[0, 8] += one.flow_gain
    result[1, 8] += two.flow_gain
    result[0, 9] += one.offset
    result[1, 9] += two.offset
    result[0, 10] += one.lap
    result[1, 10] += two.lap
    result[0, 11] += one.clearance
    result[1, 11] += two.clearance
    result[0, 12] -= one.pressure_1
    result[1, 12] -= two.pressure_1
    result[3, 12] -= by_mass * plant.area_1
    result[0, 13] -= one.pressure_2
    result[1, 13] -= two.pressure_2
    result[3, 13] += by_mass * plant.area_2
