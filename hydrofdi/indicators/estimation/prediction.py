"""Prediction of the nominal plant over one sample, and its state transition matrix.

The transition matrix is the exact derivative of the Runge-Kutta steps, propagated through every stage.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.estimation.plant import (
    N_MOVING,
    N_STATE,
    PER_MINUTE,
    STATES,
    Actual,
    Moving,
    Plant,
    RandomWalks,
    actual,
    mean_rates,
    moved,
    rates,
    true_pressures,
)
from hydrofdi.physics.equation import equation, signed_root
from hydrofdi.physics.friction import decaying_exponential, stribeck_force
from hydrofdi.records import Array

LEAST_ROOT = 0.3
"""Root of the pressure difference at which derivatives of flows are limited [√MPa]: 0.09 MPa."""


class ChamberSlopes(NamedTuple):
    """Derivatives of the rate of a chamber pressure [MPa/s] by the states, in their units."""

    pressure_1: float
    pressure_2: float
    position: float
    velocity: float
    leakage: float
    bulk_modulus: float
    supply: float
    flow_gain: float
    offset: float
    lap: float
    clearance: float


class Slopes(NamedTuple):
    """Derivatives of the rates: of both chamber pressures, and of friction by velocity [N·s/mm]."""

    chamber_1: ChamberSlopes
    chamber_2: ChamberSlopes
    friction: float


class EdgeSlopes(NamedTuple):
    """Flow through a metering edge [mm³/s], and derivatives by opening [mm] and pressure drop [MPa]."""

    opened: float
    by_opening: float
    by_drop: float


@equation
def edge_slopes(x: float, drop: float, a: Actual, plant: Plant) -> EdgeSlopes:
    """Derivatives of `edge_flow`."""
    opening, gain = max(x - a.lap, 0.0), a.flow_gain * plant.area_gradient
    root = np.sqrt(abs(drop))
    by_opening = np.copysign(gain * root, drop) if opening > 0.0 else 0.0
    return EdgeSlopes(
        by_opening * opening, by_opening, 0.5 * gain * opening / max(root, LEAST_ROOT) + a.clearance
    )


@equation
def slopes(moving: Moving, spool: float, a: Actual, plant: Plant) -> Slopes:
    """Derivatives of `rates`."""
    x, (p_1, p_2) = spool - a.offset, true_pressures(moving, a)
    to_1, from_1, to_2, from_2 = a.supply - p_1, p_1 - plant.ret, a.supply - p_2, p_2 - plant.ret
    feed_1, drain_1 = edge_slopes(x, to_1, a, plant), edge_slopes(-x, from_1, a, plant)
    feed_2, drain_2 = edge_slopes(-x, to_2, a, plant), edge_slopes(x, from_2, a, plant)
    root = signed_root(p_1 - p_2)
    leak = 0.5 * a.leakage_coefficient / max(abs(root), LEAST_ROOT)
    leaking = root * (PER_MINUTE / np.sqrt(plant.reference_pressure))
    rate, micrometre, by_gain = rates(moving, spool, a, plant), 1e-3, plant.flow_gain / a.flow_gain
    stiff_1 = a.bulk_modulus / (plant.volume_1 + plant.area_1 * moving.position)
    stiff_2 = a.bulk_modulus / (plant.volume_2 - plant.area_2 * moving.position)
    # By P_1, P_2, x_p, v_p, leakage, ln β, ln P_s, flow gain, offset, lap and clearance.
    chamber_1 = ChamberSlopes(
        -stiff_1 * (feed_1.by_drop + drain_1.by_drop + leak),
        stiff_1 * leak,
        -rate.pressure_1 * stiff_1 * plant.area_1 / a.bulk_modulus,
        -stiff_1 * plant.area_1,
        -stiff_1 * leaking,
        rate.pressure_1,
        stiff_1 * feed_1.by_drop * a.supply,
        stiff_1 * (feed_1.opened - drain_1.opened) * by_gain,
        -stiff_1 * (feed_1.by_opening + drain_1.by_opening) * micrometre,
        -stiff_1 * (feed_1.by_opening - drain_1.by_opening) * micrometre,
        stiff_1 * (to_1 - from_1),
    )
    chamber_2 = ChamberSlopes(
        stiff_2 * leak,
        -stiff_2 * (feed_2.by_drop + drain_2.by_drop + leak),
        rate.pressure_2 * stiff_2 * plant.area_2 / a.bulk_modulus,
        stiff_2 * plant.area_2,
        stiff_2 * leaking,
        rate.pressure_2,
        stiff_2 * feed_2.by_drop * a.supply,
        stiff_2 * (feed_2.opened - drain_2.opened) * by_gain,
        stiff_2 * (feed_2.by_opening + drain_2.by_opening) * micrometre,
        -stiff_2 * (feed_2.by_opening - drain_2.by_opening) * micrometre,
        stiff_2 * (to_2 - from_2),
    )
    friction = 0.0
    if plant.has_friction_model is not None:
        friction = friction_slope(moving.velocity, plant)
    return Slopes(chamber_1, chamber_2, friction)


@equation
def friction_slope(velocity: float, plant: Plant) -> float:
    """Derivative of `threshold_friction` by velocity [N·s/mm]."""
    speed, threshold = abs(velocity), plant.velocity_threshold
    if speed < threshold:
        held = stribeck_force(threshold, plant)
        steep: float = plant.viscous + held / threshold
        return steep
    fall = plant.transition * (plant.breakaway - plant.coulomb)
    sliding: float = plant.viscous - fall * decaying_exponential(plant.transition * speed)
    return sliding


LEAKAGE, BIAS_1 = STATES.index("leakage"), STATES.index("bias_1")
"""Indices of the first parameter, and of the first one behind those in `ChamberSlopes`."""

TANGENT_SHAPE = (4, N_MOVING, N_STATE)
"""Shape of the workspace of `advance_with_transition`."""


@equation
def moving_of(state: Array) -> Moving:
    """Moving states of a state vector."""
    return Moving(state[0], state[1], state[2], state[3])


@equation
def held_of(state: Array) -> RandomWalks:
    """Random walks of a state vector."""
    return RandomWalks(
        state[4], state[5], state[6], state[7], state[8], state[9], state[10], state[11], state[12], state[13]
    )


@equation
def keep_moving(state: Array, moving: Moving) -> None:
    """Write the moving states into a state vector."""
    state[0], state[1] = moving.pressure_1, moving.pressure_2
    state[2], state[3] = moving.position, moving.velocity


@equation
def advance_with_transition(
    state: Array, path: Array, step: float, supply: float, plant: Plant, transition: Array, tangents: Array
) -> None:
    """Advance a state over one sample, with the derivatives of the moving states by all at the start.

    `transition` (N_MOVING, N_STATE) is filled with ∂(moving states at the end)/∂(states at the start); the
    held states do not change. `tangents` of TANGENT_SHAPE is scratch.
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
    for j in range(LEAKAGE, BIAS_1):
        result[0, j] += one[j - 1]
        result[1, j] += two[j - 1]
    result[0, 12] -= one.pressure_1
    result[1, 12] -= two.pressure_1
    result[3, 12] -= by_mass * plant.area_1
    result[0, 13] -= one.pressure_2
    result[1, 13] -= two.pressure_2
    result[3, 13] += by_mass * plant.area_2
