"""Nominal plant of state estimators: actuator and valve, with deviations from the data sheet.

Units are mm, s, N, MPa and t (1 t·mm/s² = 1 N), so that all states have magnitudes of about 1 to 100. The
units are consistent, so the equations of `hydrofdi.physics` apply unchanged.
"""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.physics import equation, settled
from hydrofdi.physics.cylinder import chamber_pressure_rates, internal_leakage_flow, piston_acceleration
from hydrofdi.physics.friction import threshold_friction
from hydrofdi.physics.hydraulic_mode import second_order_eigenvalues
from hydrofdi.physics.valve import edge_flow
from hydrofdi.records import Array

PER_MINUTE = 1e6 / 60.0
"""1 L/min [mm³/s]."""


class Moving(NamedTuple):
    """States that change within a sample: P_1 and P_2 as measured [MPa], x_p [mm], v_p [mm/s]."""

    pressure_1: float
    pressure_2: float
    position: float
    velocity: float


class RandomWalks(NamedTuple):
    """States that are constant within a sample and perform random walks; zero for the nominal plant.

    `resistance`: friction and load [N], minus friction if that is modelled; `leakage` at the reference
    pressure [L/min]; `bulk_modulus` and `supply`: ln(β/β_nominal) and ln(P_s/P_s,nominal); `flow_gain`:
    relative deviation of the flow through the open valve; `offset` and `lap` of the spool [µm]; `clearance`:
    conductance at each edge [mm³/(s·MPa)]; biases of the sensors of P_1 and P_2 [MPa].
    """

    resistance: float
    leakage: float
    bulk_modulus: float
    supply: float
    flow_gain: float
    offset: float
    lap: float
    clearance: float
    bias_1: float
    bias_2: float


STATES = Moving._fields + RandomWalks._fields
"""Names of all states, in order."""

N_MOVING, N_STATE = len(Moving._fields), len(STATES)


class Plant(NamedTuple):
    """Nominal parameters: mass [t], areas [mm²], volumes at position zero [mm³], stiffness [N/mm].

    Bulk modulus, return and reference pressure [MPa]; K_v [mm/(s·√MPa)] and w [mm]; friction in N, N·s/mm,
    s/mm and mm/s. With `has_friction_model` True, friction follows the law of the paper; with None it is part
    of `resistance` only.
    """

    mass: float
    area_1: float
    area_2: float
    volume_1: float
    volume_2: float
    stiffness: float
    bulk_modulus: float
    ret: float
    reference_pressure: float
    flow_gain: float
    area_gradient: float
    coulomb: float
    breakaway: float
    viscous: float
    transition: float
    velocity_threshold: float
    has_friction_model: bool | None


class Actual(NamedTuple):
    """Actual parameters: nominal values changed by the held states; lengths in mm, K_i in mm³/(s·√MPa)."""

    bulk_modulus: float
    supply: float
    flow_gain: float
    offset: float
    lap: float
    clearance: float
    leakage_coefficient: float
    resistance: float
    bias_1: float
    bias_2: float


@equation
def actual(held: RandomWalks, supply: float, plant: Plant) -> Actual:
    """Actual parameters of the plant for the held states and a nominal supply pressure [MPa]."""
    return Actual(
        plant.bulk_modulus * np.exp(held.bulk_modulus),
        supply * np.exp(held.supply),
        plant.flow_gain * (1.0 + held.flow_gain),
        1e-3 * held.offset,
        1e-3 * held.lap,
        held.clearance,
        held.leakage * PER_MINUTE / np.sqrt(plant.reference_pressure),
        held.resistance,
        held.bias_1,
        held.bias_2,
    )


@equation
def true_pressures(moving: Moving, a: Actual) -> tuple[float, float]:
    """P_1 and P_2 without the biases of their sensors [MPa]."""
    return moving.pressure_1 - a.bias_1, moving.pressure_2 - a.bias_2


@equation
def valve_flows(p_1: float, p_2: float, spool: float, a: Actual, plant: Plant) -> tuple[float, float]:
    """q_1 into chamber 1 and q_2 out of chamber 2 [mm³/s] from pressures [MPa] and spool position [mm]."""
    x, w, gain = spool - a.offset, plant.area_gradient, a.flow_gain
    feed_1 = edge_flow(x, a.supply - p_1, gain, w, a.lap, a.clearance)
    drain_1 = edge_flow(-x, p_1 - plant.ret, gain, w, a.lap, a.clearance)
    feed_2 = edge_flow(-x, a.supply - p_2, gain, w, a.lap, a.clearance)
    drain_2 = edge_flow(x, p_2 - plant.ret, gain, w, a.lap, a.clearance)
    return feed_1 - drain_1, drain_2 - feed_2


@equation
def rates(moving: Moving, spool: float, a: Actual, plant: Plant) -> Moving:
    """Rates of the moving states, per second. Equations (2), (5) to (8), (11) and (12)."""
    p_1, p_2 = true_pressures(moving, a)
    q_1, q_2 = valve_flows(p_1, p_2, spool, a, plant)
    leak = internal_leakage_flow(p_1 - p_2, a.leakage_coefficient)
    x, v, beta = moving.position, moving.velocity, a.bulk_modulus
    net_1, net_2 = q_1 - leak - plant.area_1 * v, leak - q_2 + plant.area_2 * v
    rate_1, rate_2 = chamber_pressure_rates(
        x, net_1, net_2, beta, plant.volume_1, plant.volume_2, plant.area_1, plant.area_2
    )
    resistance = a.resistance
    if plant.has_friction_model is not None:
        resistance = resistance + threshold_friction(v, 0.0, plant)[0]
    force = plant.area_1 * (p_1 - p_2 * (plant.area_2 / plant.area_1))
    acceleration = piston_acceleration(x, force, resistance, plant.mass, plant.stiffness)
    return Moving(rate_1, rate_2, v, acceleration)


@equation
def moved(moving: Moving, time: float, along: Moving) -> Moving:
    """States after moving with constant rates for a time [s]."""
    return Moving(
        moving.pressure_1 + time * along.pressure_1,
        moving.pressure_2 + time * along.pressure_2,
        moving.position + time * along.position,
        moving.velocity + time * along.velocity,
    )


@equation
def mean_rates(first: Moving, second: Moving, third: Moving, fourth: Moving) -> Moving:
    """Mean rates over a step of classic Runge-Kutta."""
    s = 1.0 / 6.0
    return Moving(
        s * (first.pressure_1 + 2.0 * (second.pressure_1 + third.pressure_1) + fourth.pressure_1),
        s * (first.pressure_2 + 2.0 * (second.pressure_2 + third.pressure_2) + fourth.pressure_2),
        s * (first.position + 2.0 * (second.position + third.position) + fourth.position),
        s * (first.velocity + 2.0 * (second.velocity + third.velocity) + fourth.velocity),
    )


@equation
def step_of(
    moving: Moving, step: float, start: float, middle: float, end: float, a: Actual, plant: Plant
) -> Moving:
    """States after one Runge-Kutta step [s]; spool positions at its start, middle and end [mm]."""
    first = rates(moving, start, a, plant)
    second = rates(moved(moving, 0.5 * step, first), middle, a, plant)
    third = rates(moved(moving, 0.5 * step, second), middle, a, plant)
    fourth = rates(moved(moving, step, third), end, a, plant)
    return moved(moving, step, mean_rates(first, second, third, fourth))


def spool_transition(frequency: float, damping_ratio: float, time: float) -> Array:
    """State transition matrix (2, 2) of the lag x'' = ω²(x_end − x) − 2ξω x' over a time [s].

    e^(At) for x − x_end and velocity, by Sylvester's formula; ξ = 1 is shifted by 1e-6.
    """
    damping = damping_ratio if abs(damping_ratio - 1.0) > 1e-6 else 1.0 + 1e-6
    one, two = second_order_eigenvalues(frequency, damping)
    matrix = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])
    unit = np.eye(2)
    first, second = cmath.exp(one * time) / (one - two), cmath.exp(two * time) / (two - one)
    return np.ascontiguousarray((first * (matrix - two * unit) + second * (matrix - one * unit)).real)


@equation
def follow_command(spool: Array, target: float, transition: Array, path: Array) -> None:
    """Fill the spool positions over one sample under a held command [mm].

    `spool`: position and velocity at the start, updated to the end; `target`: static position under the
    command; `transition`: `spool_transition` over one part of the path.
    """
    distance, velocity = spool[0] - target, spool[1]
    path[0] = spool[0]
    for i in range(1, path.size):
        ahead = transition[0, 0] * distance + transition[0, 1] * velocity
        velocity = settled(transition[1, 0] * distance + transition[1, 1] * velocity)
        distance = settled(ahead)
        path[i] = target + distance
    spool[0], spool[1] = target + distance, velocity


@equation
def between_samples(start: float, end: float, path: Array) -> None:
    """Fill a path with linearly interpolated positions between two samples [mm]."""
    for i in range(path.size):
        path[i] = start + (end - start) * (i / (path.size - 1))


Places = NDArray[np.int64]

N_MEASURED = 3
"""Number of measurements: P_1, P_2 and x_p, the first of the states."""

FIRST_PARAMETER = STATES.index("leakage")
"""Index of the first state that is neither motion nor force."""


class Tuning(NamedTuple):
    """Known parameters of plant and sensors.

    `step` of Runge-Kutta [s]; `spool_transition` (2, 2) over half a step; whether the spool `follows_command`
    or is measured; initial variance `prior` and process noise `walk` per sample of each estimated state, of
    an unscented filter their roots; variances of the `sensors` [MPa², MPa², mm²]; `limits` of each estimate;
    `places`: indices of the estimated states in ``STATES``, moving states first; all other states are zero.
    Parameters are not updated while the spool is within `null_zone` of its centre, or travels more than
    `largest_travel` within a sample [mm].
    """

    plant: Plant
    step: float
    spool_transition: Array
    follows_command: bool
    prior: Array
    walk: Array
    sensors: Array
    limits: Array
    places: Places
    null_zone: float
    largest_travel: float

    def of_roots(self, places: Places) -> Tuning:
        """For an unscented filter of some states."""
        prior, walk = np.sqrt(self.prior[places]), np.sqrt(self.walk[places])
        return self._replace(prior=prior, walk=walk, limits=self.limits[places], places=places)


@equation
def find_path(spool: Array, before: float, drive: float, tuning: Tuning, path: Array) -> bool:
    """Fill the path of a spool to the next sample; return whether the valve stays open and nearly at rest."""
    if tuning.follows_command:
        follow_command(spool, before, tuning.spool_transition, path)
    else:
        between_samples(before, drive, path)
    least, most = min(path[0], path[-1]), max(path[0], path[-1])
    is_open: bool = least > tuning.null_zone or most < -tuning.null_zone
    return is_open and most - least <= tuning.largest_travel
