import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.physics.friction.stribeck import decaying_exponential
from hydrofdi.physics.friction.threshold import friction_force

velocities = st.floats(-5.0, 5.0) | st.floats(-1e-2, 1e-2) | st.floats(-1e-5, 1e-5)
forces, coefficients, thresholds = st.floats(0.0, 1e4), st.floats(0.0, 1e3), st.floats(1e-6, 1e-1)
parameter_sets = st.tuples(forces, forces, coefficients, coefficients, thresholds)


def printed_friction(v, F_c, F_brk, f, c_v, v_th):
    """Equation (12) as it is printed, in two cases."""
    if abs(v) >= v_th:
        return (F_c + (F_brk - F_c) * math.exp(-c_v * abs(v))) * math.copysign(1.0, v) + f * v
    return v * (f * v_th + F_c + (F_brk - F_c) * math.exp(-c_v * v_th)) / v_th


@given(velocities, parameter_sets)
def test_both_cases_are_those_of_the_printed_equation(v, parameters):
    expected = printed_friction(v, *parameters)
    F_c, F_brk, f, _, _ = parameters
    scale = F_c + F_brk + f * abs(v) + 1e-9
    assert friction_force(v, *parameters) == pytest.approx(expected, abs=2e-11 * scale)


@given(velocities, parameter_sets)
def test_friction_is_odd_in_velocity(v, parameters):
    assert friction_force(-v, *parameters) == -friction_force(v, *parameters)


@given(velocities, parameter_sets)
def test_friction_opposes_the_motion(v, parameters):
    assert friction_force(v, *parameters) * v >= 0.0


def test_friction_of_the_nominal_actuator_by_hand():
    nominal = (200.0, 250.0, 50.0, 40.0, 1e-3)
    # 200 + 50 e^(-40·0.1) + 50·0.1 = 205 + 50·0.0183156388887
    assert friction_force(0.1, *nominal) == pytest.approx(205.915781944, rel=1e-11)
    # 0.5e-3·(50·1e-3 + 200 + 50 e^(-0.04))/1e-3 = 0.5·(200.05 + 48.0394719576)
    assert friction_force(0.5e-3, *nominal) == pytest.approx(124.044735979, rel=1e-11)
    assert friction_force(0.0, *nominal) == 0.0


def test_friction_is_continuous_at_the_threshold():
    nominal = (200.0, 250.0, 50.0, 40.0, 1e-3)
    below, above = (friction_force(1e-3 * factor, *nominal) for factor in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above, rel=1e-8)


def test_fast_motion_leaves_coulomb_and_viscous_friction():
    assert friction_force(100.0, 200.0, 250.0, 50.0, 40.0, 1e-3) == pytest.approx(5200.0, abs=1e-9)


def test_the_exponential_errs_by_less_than_3e_12_everywhere():
    exponents = np.concatenate([np.linspace(0.0, 70.0, 70_001), np.geomspace(1e-12, 1e6, 20_001)])
    errors = [abs(decaying_exponential(x) - math.exp(-x)) for x in exponents]
    assert max(errors) < 3e-12


@given(st.floats(0.0, 1e6))
def test_the_exponential_stays_between_zero_and_one(exponent):
    assert 0.0 <= decaying_exponential(exponent) <= 1.0


def test_the_exponential_of_nothing_is_one():
    assert decaying_exponential(0.0) == 1.0
