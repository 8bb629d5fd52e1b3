"""Analytic Jacobian of the nominal plant: derivatives of the rates by all states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.estimation.plant import PER_MINUTE, Actual, Moving, Plant, rates, true_pressures
from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.stribeck import decaying_exponential, stribeck_force
from hydrofdi.physics.signed_root import signed_root

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
    """Derivative of `friction_force` by velocity [N·s/mm]."""
    speed, threshold = abs(velocity), plant.velocity_threshold
    if speed < threshold:
        held = stribeck_force(threshold, plant.coulomb, plant.breakaway, plant.transition)
        steep: float = plant.viscous + held / threshold
        return steep
    fall = plant.transition * (plant.breakaway - plant.coulomb)
    sliding: float = plant.viscous - fall * decaying_exponential(plant.transition * speed)
    return sliding
