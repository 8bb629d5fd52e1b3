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
from hydrofdi.physics import equation, signed_root
from hydrofdi.physics.friction import decaying_exponential, stribeck_force
from hydrofdi.records import Array

LEAST_ROOT = 0.3
"""Root of the pressure difference at which derivatives of flows are limited [√MPa]: 0.09 MPa."""


class ChamberSlopes(NamedTuple):
    """Derivatives of the rate of a chamber pressure [MPa/s] by the states, in their units.

    By the chamber's own pressure, by that of the other one, and by the others in the order of ``STATES``.
    """

    own: float
    other: float
    position: float
    velocity: float
    leakage: float
    bulk_modulus: float
    supply: float
    flow_gain: float
    offset: float
    lap: float
    clearance: float


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
def chamber_slopes(
    pressure: float, rate: float, volume: float, area: float, x: float, root: float, sign: float, a: Actual,
    plant: Plant,
) -> ChamberSlopes:  # fmt: skip
    """Derivatives of the rate of a chamber; chamber 2 mirrors chamber 1 (`sign` −1)."""
    to, off, stiffness = a.supply - pressure, pressure - plant.ret, a.bulk_modulus / volume
    feed, drain = edge_slopes(sign * x, to, a, plant), edge_slopes(-sign * x, off, a, plant)
    leak = 0.5 * a.leakage_coefficient / max(abs(root), LEAST_ROOT)
    leaking = root * (PER_MINUTE / np.sqrt(plant.reference_pressure))
    mirrored, micrometre = -sign * stiffness, 1e-3
    return ChamberSlopes(
        -stiffness * (feed.by_drop + drain.by_drop + leak),
        stiffness * leak,
        -sign * rate * stiffness * area / a.bulk_modulus,
        mirrored * area,
        mirrored * leaking,
        rate,
        stiffness * feed.by_drop * a.supply,
        stiffness * (feed.opened - drain.opened) * (plant.flow_gain / a.flow_gain),
        mirrored * (feed.by_opening + drain.by_opening) * micrometre,
        -stiffness * (feed.by_opening - drain.by_opening) * micrometre,
        stiffness * (to - off),
    )


@equation
def slopes(
    moving: Moving, spool: float, a: Actual, plant: Plant
) -> tuple[ChamberSlopes, ChamberSlopes, float]:
    """Derivatives of `rates`: of both chamber pressures, and of friction by velocity [N·s/mm]."""
    x, (p_1, p_2), rate = spool - a.offset, true_pressures(moving, a), rates(moving, spool, a, plant)
    root, friction = signed_root(p_1 - p_2), 0.0
    volume_1 = plant.volume_1 + plant.area_1 * moving.position
    volume_2 = plant.volume_2 - plant.area_2 * moving.position
    one = chamber_slopes(p_1, rate.pressure_1, volume_1, plant.area_1, x, root, 1.0, a, plant)
    two = chamber_slopes(p_2, rate.pressure_2, volume_2, plant.area_2, x, root, -1.0, a, plant)
    if plant.has_friction_model is not None:
        friction = friction_slope(moving.velocity, plant)
    return one, two, friction


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
def drive(
    tangent: Array, by: tuple[ChamberSlopes, ChamberSlopes, float], plant: Plant, result: Array
) -> None:
    """Rates of a tangent: the Jacobian of the plant times the tangent."""
    (one, two, friction), by_mass = by, 1.0 / plant.mass
    for j in range(N_STATE):
        p_1, p_2, x, v = tangent[0, j], tangent[1, j], tangent[2, j], tangent[3, j]
        result[0, j] = one.own * p_1 + one.other * p_2 + one.position * x + one.velocity * v
        result[1, j] = two.other * p_1 + two.own * p_2 + two.position * x + two.velocity * v
        result[2, j] = v
        force = plant.area_1 * p_1 - plant.area_2 * p_2 - plant.stiffness * x - friction * v
        result[3, j] = by_mass * force
    result[3, 4] -= by_mass
    for j in range(LEAKAGE, BIAS_1):
        result[0, j] += one[j - 1]
        result[1, j] += two[j - 1]
    result[0, 12] -= one.own
    result[1, 12] -= two.other
    result[3, 12] -= by_mass * plant.area_1
    result[0, 13] -= one.other
    result[1, 13] -= two.own
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
def find_gain(covariance: Array, index: int, total: float, is_trusted: bool, gain: Array) -> None:
    """Fill the Kalman gain of a measurement of one state, given the total innovation variance.

    If the measurement is not trusted, the gain of parameters is zero: only their variances are considered,
    Schmidt, Advances in Control Systems 3 (1966).
    """
    for j in range(N_STATE):
        gain[j] = covariance[index, j] / total
    if not is_trusted:
        for j in range(FIRST_PARAMETER, N_STATE):
            gain[j] = 0.0


@equation
def learn(covariance: Array, index: int, total: float, gain: Array, row: Array) -> None:
    """Update a covariance P for a measurement of state i with any gain K, in place.

    (1 − K e_iᵀ) P (1 − K e_iᵀ)ᵀ + r K Kᵀ = P − K p − (p − s K) Kᵀ with p = row i of P and s = P_ii + r.
    """
    for j in range(N_STATE):
        row[j] = covariance[index, j]
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
    for index in range(N_MEASURED):
        innovation = measured[index] - mean[index]
        total = covariance[index, index] + tuning.sensors[index]
        find_gain(covariance, index, total, is_open, work.gain)
        learn(covariance, index, total, work.gain, work.row)
        offset = signature[index]
        for j in range(N_STATE):
            mean[j] += work.gain[j] * innovation
            signature[j] -= work.gain[j] * offset
        sums[0] += innovation * innovation / total
        sums[1] += innovation * innovation if index < 2 else 0.0
        if is_open:
            sums[2] += offset * innovation / total
            sums[3] += offset * offset / total
    make_symmetric(covariance)
