"""Laws of friction."""

import math

import numpy as np
import pytest
from free_motion import FREE, free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config.machine import FrictionConfig
from hydrofdi.physics import friction
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.hydraulics import State, friction_of
from hydrofdi.simulation.lanes import ModelOptions
from tests.machines import HOSES, machine


@given(st.floats(min_value=0.0, max_value=200.0))
def test_polynomial_exponential_is_exact_to_eleven_digits(exponent: float) -> None:
    assert friction.decaying_exponential(exponent) == pytest.approx(math.exp(-exponent), abs=3e-12)


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


def test_sticking_piston_rings_on_its_bristles() -> None:
    """Small motion about rest: ω = √(σ_0/m), ζ = (σ_1 + f)/(2√(σ_0 m))."""
    own = {"fluid.bulk_modulus": 1.0, "friction.bristle_damping": 200.0, "friction.viscous": 0.0}
    velocity = free_motion([FREE | own], [{"velocity": 1e-6}], [0.0], 0.05, 1e-5, HOSES)["velocity"][0]
    time = 1e-5 * np.arange(velocity.size)
    omega, ratio = math.sqrt(5e6 / 12.3), 200.0 / (2.0 * math.sqrt(5e6 * 12.3))
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = np.cos(damped * time) - ratio * omega / damped * np.sin(damped * time)
    np.testing.assert_allclose(velocity, 1e-6 * np.exp(-ratio * omega * time) * wave, atol=1e-9)


def test_pressure_on_the_seals_and_place_in_the_cylinder_scale_dry_friction_alone() -> None:
    """A coasting piston decelerates by (F_c factor + f v)/m, where pressures are equal and held."""
    values = FREE | {
        "friction.coulomb": 200.0, "friction.breakaway": 200.0, "friction.viscous": 50.0,
        "friction.pressure_slope": 1e-7, "friction.position_share": 0.3, "friction.position_period": 0.1,
        "fluid.bulk_modulus": 1.0,
    }  # fmt: skip
    places = ((0.0, 0.0), (0.025, 0.0), (0.0, 1e6), (0.0, -1e6), (0.075, 1e6))
    start = [
        {"velocity": 0.2, "position": x, "pressure_1": 8e6 + difference, "pressure_2": 8e6}
        for x, difference in places
    ]
    motion = free_motion([values] * len(start), start, [0.0] * len(start), 2e-4, 1e-5)
    force = -12.3 * np.diff(motion["velocity"][:, :2])[:, 0] / 1e-5
    force += 633e-6 * (motion["pressure_1"] - motion["pressure_2"])[:, 0]
    expected = 200.0 * np.array([1.0, 1.3, 1.1, 1.1, 1.1 * 0.7]) + 50.0 * 0.2
    np.testing.assert_allclose(force, expected, rtol=1e-3)
