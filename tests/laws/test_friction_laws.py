"""Laws of friction."""

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config.machine import FrictionConfig
from hydrofdi.physics import friction
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.hydraulics import State, friction_of
from hydrofdi.simulation.lanes import ModelOptions
from tests.machines import HOSES, machine

PARAMETERS = FrictionConfig()


def friction_force(velocity: float, p: FrictionConfig = PARAMETERS) -> float:
    return friction.threshold_friction(velocity, 0.0, p)[0]


def smooth_friction_force(velocity: float) -> float:
    return friction.smooth_friction(velocity, 0.0, PARAMETERS)[0]


speeds = st.floats(min_value=-2.0, max_value=2.0)


@given(speeds)
def test_friction_is_odd_takes_power_and_both_laws_agree_far_above_the_threshold(velocity: float) -> None:
    for law in (friction_force, smooth_friction_force):
        assert law(-velocity) == -law(velocity)
        assert law(velocity) * velocity >= 0.0
    if abs(velocity) > 0.02:
        assert smooth_friction_force(velocity) == pytest.approx(friction_force(velocity), rel=1e-9)


@given(st.floats(min_value=0.0, max_value=200.0))
def test_polynomial_exponential_is_exact_to_eleven_digits(exponent: float) -> None:
    assert friction.decaying_exponential(exponent) == pytest.approx(math.exp(-exponent), abs=3e-12)


def test_friction_is_continuous_and_coulomb_and_viscous_alone_at_speed() -> None:
    below, above = (friction_force(1e-3 * factor) for factor in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above, rel=1e-6)
    assert friction_force(1.5) == pytest.approx(200.0 + 50.0 * 1.5, rel=1e-12)


def test_coulomb_friction_stops_a_coasting_piston_after_the_classical_time() -> None:
    """With both chambers open to one pressure a mass coasts to rest in v_0 m/F_c."""
    values = {
        **FRICTIONLESS, "friction.coulomb": 200.0, "friction.breakaway": 200.0,
        "actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.0,
    }  # fmt: skip
    step, speed = 1e-5, 0.2
    motion = free_motion([values], [{"velocity": speed}], [0.0], 0.02, step)
    stop = speed * 12.3 / 200.0
    time = step * np.arange(motion["velocity"].shape[1])
    moving = time < 0.95 * stop
    np.testing.assert_allclose(motion["velocity"][0][moving], speed * (1 - time[moving] / stop), atol=1e-7)
    assert abs(motion["velocity"][0][-1]) < 1e-4


def test_smooth_friction_follows_the_hyperbolic_tangent_through_zero() -> None:
    for velocity in (1e-5, 3e-4, 1e-3, 3e-3):
        dry = (200.0 + 50.0 * math.exp(-40.0 * velocity)) * math.tanh(velocity / 1e-3)
        assert smooth_friction_force(velocity) == pytest.approx(dry + 50.0 * velocity, rel=1e-8)


@pytest.mark.parametrize("law", friction.LAWS, ids=lambda law: law.name)
def test_a_run_has_the_law_that_was_chosen(law: friction.FrictionLaw) -> None:
    p = FrictionConfig(bristle_stiffness=3e5).applied
    state = State(*[0.0] * len(State._fields))._replace(velocity=1e-4, bristle=1e-5)
    found = friction_of(state, p, ModelOptions(friction_law=law.name))
    assert found == law.friction(1e-4, 1e-5, p)
    assert sum(found == other.friction(1e-4, 1e-5, p) for other in friction.LAWS) == 1


def test_scale_zero_is_the_actuator_without_dry_friction_also_on_bristles() -> None:
    bare, scaled = {"friction.coulomb": 0.0, "friction.breakaway": 0.0}, {"friction.scale": 0.0}
    for base in ({}, HOSES):
        runs = [machine(values, base) for values in (bare, scaled)]
        np.testing.assert_array_equal(*simulate_batch(runs, [1e-9] * 2).chamber_1_pressure)


@pytest.mark.long
def test_without_dry_friction_bristles_are_a_threshold() -> None:
    runs = [machine({"friction.scale": 0.0, "friction.law": law}, {}) for law in ("threshold", "lugre")]
    np.testing.assert_allclose(*simulate_batch(runs, [1e-9] * 2).chamber_1_pressure, rtol=1e-9)


@pytest.mark.parametrize("velocity", [-0.2, 2e-3, 0.05])
def test_bristles_in_steady_motion_give_the_stribeck_force(velocity: float) -> None:
    dry = PARAMETERS.model_copy(update={"viscous": 0.0, "velocity_threshold": 1e-9})
    stribeck = friction_force(velocity, dry)
    steady, rate = friction.bristle_friction(velocity, stribeck / 5e6, PARAMETERS)
    assert abs(rate) < 1e-9 * abs(velocity)
    assert steady == pytest.approx(stribeck + 50.0 * velocity, rel=1e-6)


def test_sticking_piston_rings_on_its_bristles() -> None:
    """Small motion about rest: ω = √(σ_0/m), ζ = (σ_1 + f)/(2√(σ_0 m))."""
    values = {
        "actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.0, "friction.bristle_damping": 200.0,
        "friction.viscous": 0.0,
    }  # fmt: skip
    step = 1e-5
    velocity = free_motion([values], [{"velocity": 1e-6}], [0.0], 0.05, step, HOSES)["velocity"][0]
    time = step * np.arange(velocity.size)
    omega, ratio = math.sqrt(5e6 / 12.3), 200.0 / (2.0 * math.sqrt(5e6 * 12.3))
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = np.cos(damped * time) - ratio * omega / damped * np.sin(damped * time)
    np.testing.assert_allclose(velocity, 1e-6 * np.exp(-ratio * omega * time) * wave, atol=1e-9)


def test_bristles_hold_a_load_below_breakaway_and_let_go_above_it() -> None:
    values = {
        "input.amplitude": 0.0, "actuator.load_stiffness": 0.0, "friction.viscous": 2000.0,
    }  # fmt: skip
    runs = [machine({**values, "load.constant_force": force}, HOSES) for force in (120.0, 400.0)]
    record = simulate_batch(runs, [5e-8, 5e-8])  # a wide leak: the fluid bears nothing
    held, loose = np.abs(record.piston_position[:, -1])
    assert 120.0 / 5e6 < held < 4 * 120.0 / 5e6
    assert np.abs(record.piston_velocity[0, -50:]).max() < 1e-5
    assert loose > 100 * 400.0 / 5e6


def test_pressure_on_the_seals_and_place_in_the_cylinder_scale_dry_friction_alone() -> None:
    """A coasting piston decelerates by (F_c factor + f v)/m, where pressures are equal and held."""
    values = {
        "friction.coulomb": 200.0, "friction.breakaway": 200.0, "friction.viscous": 50.0,
        "actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.0,
    }  # fmt: skip
    uneven = {
        "friction.pressure_slope": 1e-7,
        "friction.position_share": 0.3,
        "friction.position_period": 0.1,
    }
    difference, speed = 1e6, 0.2
    start = [
        {"velocity": speed, "position": x, "pressure_1": 8e6 + side * difference, "pressure_2": 8e6}
        for x, side in ((0.0, 0.0), (0.025, 0.0), (0.0, 1.0), (0.0, -1.0), (0.075, 1.0))
    ]
    motion = free_motion([values | uneven] * len(start), start, [0.0] * len(start), 2e-4, 1e-5)
    force = -12.3 * np.diff(motion["velocity"][:, :2])[:, 0] / 1e-5
    force += 633e-6 * (motion["pressure_1"] - motion["pressure_2"])[:, 0]
    expected = 200.0 * np.array([1.0, 1.3, 1.1, 1.1, 1.1 * 0.7]) + 50.0 * speed
    np.testing.assert_allclose(force, expected, rtol=1e-3)
