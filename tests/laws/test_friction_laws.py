"""Laws of friction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import RunParameters
from hydrofdi.physics.friction import decaying_exponential, friction_force, smooth_friction_force
from hydrofdi.simulation import simulate_batch

PARAMETERS = (200.0, 250.0, 50.0, 40.0, 1e-3)
speeds = st.floats(min_value=-2.0, max_value=2.0)


@given(speeds)
def test_friction_is_odd_in_velocity(velocity: float) -> None:
    assert friction_force(-velocity, *PARAMETERS) == -friction_force(velocity, *PARAMETERS)


@given(speeds)
def test_friction_takes_power_from_the_piston(velocity: float) -> None:
    assert friction_force(velocity, *PARAMETERS) * velocity >= 0.0


@given(st.floats(min_value=0.0, max_value=200.0))
def test_polynomial_exponential_is_exact_to_eleven_digits(exponent: float) -> None:
    assert decaying_exponential(exponent) == pytest.approx(math.exp(-exponent), abs=3e-12)


def test_friction_is_continuous_at_the_velocity_threshold() -> None:
    below, above = (friction_force(1e-3 * factor, *PARAMETERS) for factor in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above, rel=1e-6)


def test_fast_piston_feels_coulomb_and_viscous_friction_alone() -> None:
    assert friction_force(1.5, *PARAMETERS) == pytest.approx(200.0 + 50.0 * 1.5, rel=1e-12)


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


@given(speeds)
def test_smooth_friction_is_odd_and_takes_power(velocity: float) -> None:
    force = smooth_friction_force(velocity, *PARAMETERS)
    assert force == -smooth_friction_force(-velocity, *PARAMETERS)
    assert force * velocity >= 0.0


@given(st.floats(min_value=0.02, max_value=2.0))
def test_both_friction_laws_agree_far_above_the_threshold(velocity: float) -> None:
    smooth, kinked = smooth_friction_force(velocity, *PARAMETERS), friction_force(velocity, *PARAMETERS)
    assert smooth == pytest.approx(kinked, rel=1e-9)


def test_smooth_friction_follows_the_hyperbolic_tangent_through_zero() -> None:
    for velocity in (1e-5, 3e-4, 1e-3, 3e-3):
        dry = (200.0 + 50.0 * math.exp(-40.0 * velocity)) * math.tanh(velocity / 1e-3)
        assert smooth_friction_force(velocity, *PARAMETERS) == pytest.approx(dry + 50.0 * velocity, rel=1e-8)


def test_scale_zero_is_the_actuator_without_dry_friction() -> None:
    short = RunParameters().with_values({"run.duration": 1.0, "input.period": 0.5})
    scaled = short.with_values({"friction.scale": 0.0})
    bare = short.with_values({"friction.coulomb": 0.0, "friction.breakaway": 0.0})
    trajectory = simulate_batch([scaled, bare], [1e-9, 1e-9])
    np.testing.assert_array_equal(*trajectory.chamber_1_pressure)
