"""The hydraulic mode: ring-downs of the simulation against its linearised formulas."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics.hydraulic_mode import (
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    valve_flow_pressure_coefficient,
)

STIFFNESS, POSITION, VISCOUS = 5e3, 0.02, 50.0
BULK_MODULI = [551e6, 689e6, 827e6]
COEFFICIENTS = [0.0, 1e-9, 3e-9, 6e-9]
CASES = list(itertools.product(BULK_MODULI, COEFFICIENTS))
NOMINAL = RunParameters()
AREA, VOLUME, MASS = (
    NOMINAL.actuator.piston_area,
    NOMINAL.actuator.chamber_volume,
    NOMINAL.actuator.mass,
)
DIFFERENCE = STIFFNESS * POSITION / AREA


def _opening(coefficient: float) -> float:
    """Spool position whose flow just feeds the leak: the piston stands still against the spring."""
    valve, drop = NOMINAL.valve, 0.5 * (NOMINAL.supply.pressure - DIFFERENCE)
    return coefficient * math.sqrt(DIFFERENCE) / (valve.flow_gain * valve.area_gradient * math.sqrt(drop))


def _formula(bulk_modulus: float, coefficient: float) -> tuple[float, float]:
    omega = mode_frequency(bulk_modulus, AREA, VOLUME, MASS, STIFFNESS)
    valve = valve_flow_pressure_coefficient(
        _opening(coefficient), 0.5 * (NOMINAL.supply.pressure - DIFFERENCE),
        NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient,
    )  # fmt: skip
    conductance = leakage_conductance(DIFFERENCE, coefficient)
    return omega, mode_damping_ratio(omega, bulk_modulus, VOLUME, MASS, VISCOUS, valve, conductance)


def _measured(velocity: NDArray[np.float64], step: float) -> tuple[float, float]:
    """ω [rad/s] and ζ of a ring-down, from upward zero crossings and the peaks between them."""
    before = np.flatnonzero((velocity[:-1] <= 0.0) & (velocity[1:] > 0.0))
    crossings = step * (before - velocity[before] / (velocity[before + 1] - velocity[before]))
    peaks = [velocity[a : b + 1].max() for a, b in itertools.pairwise(before)]
    damped = 2.0 * math.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    decay = math.log(peaks[0] / peaks[-1]) * damped / (2.0 * math.pi * (len(peaks) - 1))
    omega = math.hypot(damped, decay)
    return omega, decay / omega


@pytest.fixture(scope="module")
def ring_downs() -> list[tuple[float, float]]:
    """Measured ω and ζ of every case, kicked by 0.1 mm/s from the equilibrium."""
    step = 2e-5
    values = [
        {
            "actuator.load_stiffness": STIFFNESS, "fluid.bulk_modulus": bulk_modulus,
            "leakage.internal_coefficient": coefficient, **FRICTIONLESS, "friction.viscous": VISCOUS,
        }
        for bulk_modulus, coefficient in CASES
    ]  # fmt: skip
    mean = 0.5 * NOMINAL.supply.pressure
    start = {
        "position": POSITION, "velocity": 1e-4,
        "pressure_1": mean + 0.5 * DIFFERENCE, "pressure_2": mean - 0.5 * DIFFERENCE,
    }  # fmt: skip
    spool = [_opening(coefficient) for _, coefficient in CASES]
    motion = free_motion(values, [start] * len(CASES), spool, 0.15, step)
    return [_measured(velocity, step) for velocity in motion["velocity"]]


def test_ring_down_has_the_frequency_of_the_formula(ring_downs: list[tuple[float, float]]) -> None:
    expected = [_formula(*case)[0] for case in CASES]
    np.testing.assert_allclose([omega for omega, _ in ring_downs], expected, rtol=0.01)


def test_ring_down_has_the_damping_of_the_formula(ring_downs: list[tuple[float, float]]) -> None:
    expected = [_formula(*case)[1] for case in CASES]
    np.testing.assert_allclose([zeta for _, zeta in ring_downs], expected, rtol=0.01)


def test_piston_without_friction_and_leak_rings_for_ever() -> None:
    start = {"velocity": 0.01}
    motion = free_motion([{"actuator.load_stiffness": 0.0, **FRICTIONLESS}], [start], [0.0], 1.0, 1e-5)
    velocity = motion["velocity"][0]
    assert velocity[-2000:].max() == pytest.approx(0.01, rel=1e-3)


def test_incompressible_limit_moves_the_piston_with_the_control_flow() -> None:
    """The piston swings about the kinematic motion by q/(A ω_h), which vanishes as 1/√β."""
    opening, step = 22e-6, 2e-6
    moduli = [551e6, 5.51e9, 55.1e9]
    values = [
        {"fluid.bulk_modulus": modulus, "actuator.load_stiffness": 0.0, **FRICTIONLESS} for modulus in moduli
    ]
    motion = free_motion(values, [{}] * 3, [opening], 0.02, step)
    drop = 0.5 * NOMINAL.supply.pressure
    speed = NOMINAL.valve.flow_gain * NOMINAL.valve.area_gradient * opening * math.sqrt(drop) / AREA
    swing = np.abs(motion["position"] - speed * step * np.arange(10_000)).max(axis=1)
    expected = [speed / mode_frequency(modulus, AREA, VOLUME, MASS, 0.0) for modulus in moduli]
    np.testing.assert_allclose(swing, expected, rtol=0.05)
