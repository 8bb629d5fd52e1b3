"""Extended Kalman filter: prediction and correction of one sample.

The transition matrix is the exact derivative of the Runge-Kutta steps, propagated through every stage.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.estimation.plant import (
    FIRST_PARAMETER,
    N_MEASURED,
    N_MOVING,
    N_STATE,
    PER_MINUTE,
    STATES,
    Actual,
    Moving,
    Plant,
    RandomWalks,
    Tuning,
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


@equation
def spread(covariance: Array, transition: Array, walk: Array, rows: Array) -> None:
    """Propagate a covariance over one sample in place, by the derivatives of the moving states."""
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


class Workspace(NamedTuple):
    """Scratch arrays of a filter: spool path, and those of a prediction and a correction."""

    path: Array
    transition: Array
    tangents: Array
    rows: Array
    gain: Array
    row: Array


def workspace(n_step: int) -> Workspace:
    """Allocate scratch arrays for `n_step` Runge-Kutta steps per sample."""
    moving = (N_MOVING, N_STATE)
    shapes = ((2 * n_step + 1,), moving, TANGENT_SHAPE, moving, (N_STATE,), (N_STATE,))
    return Workspace(*map(np.empty, shapes))


@equation
def predict(
    mean: Array, covariance: Array, signature: Array, supply: float, tuning: Tuning, work: Workspace
) -> None:
    """Predict a filter over one sample, along the spool path in its workspace; supply pressure [MPa]."""
    advance_with_transition(
        mean, work.path, tuning.step, supply, tuning.plant, work.transition, work.tangents
    )
    spread(covariance, work.transition, tuning.walk, work.rows)
    carry_signature(signature, work.transition)


@equation
def carry_signature(signature: Array, transition: Array) -> None:
    """Propagate the error of the filter with the plant, and add the effect of the leak over one sample."""
    leak = FIRST_PARAMETER
    first, second, third, fourth = (
        transition[0, leak], transition[1, leak], transition[2, leak], transition[3, leak],
    )  # fmt: skip
    for j in range(FIRST_PARAMETER):
        first += transition[0, j] * signature[j]
        second += transition[1, j] * signature[j]
        third += transition[2, j] * signature[j]
        fourth += transition[3, j] * signature[j]
    signature[0], signature[1], signature[2], signature[3] = first, second, third, fourth


@equation
def correct(
    mean: Array, covariance: Array, signature: Array, sums: Array, measured: Array, is_open: bool,
    tuning: Tuning, work: Workspace,
) -> None:  # fmt: skip
    """Correct a filter by the measurements of a sample, and accumulate the innovations."""
    for place in range(N_MEASURED):
        innovation = measured[place] - mean[place]
        total = covariance[place, place] + tuning.sensors[place]
        find_gain(covariance, place, total, is_open, work.gain)
        learn(covariance, place, total, work.gain, work.row)
        offset = signature[place]
        for j in range(N_STATE):
            mean[j] += work.gain[j] * innovation
            signature[j] -= work.gain[j] * offset
        sums[0] += innovation * innovation / total
        sums[1] += innovation * innovation if place < 2 else 0.0
        if is_open:
            sums[2] += offset * innovation / total
            sums[3] += offset * offset / total
    make_symmetric(covariance)
