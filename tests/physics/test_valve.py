import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.physics.signed_root import signed_root
from hydrofdi.physics.valve import (
    chamber_1_orifice_drop,
    chamber_2_orifice_drop,
    control_flow,
    spool_acceleration,
)

pressures = st.floats(0.0, 40e6)
openings = st.floats(1e-9, 1e-3)


@given(openings, pressures, st.floats(10e6, 30e6), st.floats(0.0, 5e6))
def test_an_open_spool_connects_chamber_1_to_supply_and_chamber_2_to_return(x_v, p, p_s, p_r):
    assert chamber_1_orifice_drop(x_v, p, p_s, p_r) == pytest.approx(p_s - p, abs=1e-6)
    assert chamber_2_orifice_drop(x_v, p, p_s, p_r) == pytest.approx(p - p_r, abs=1e-6)


@given(openings, pressures, st.floats(10e6, 30e6), st.floats(0.0, 5e6))
def test_a_spool_on_the_other_side_swaps_the_chambers(x_v, p, p_s, p_r):
    assert chamber_1_orifice_drop(-x_v, p, p_s, p_r) == pytest.approx(p - p_r, abs=1e-6)
    assert chamber_2_orifice_drop(-x_v, p, p_s, p_r) == pytest.approx(p_s - p, abs=1e-6)


def test_control_flow_of_the_nominal_valve_by_hand():
    # 0.0292·0.02075·44e-6·√8.6e6 = 2.66596e-8·2932.5757
    drop = chamber_1_orifice_drop(44e-6, 8.6e6, 17.2e6, 0.0)
    assert control_flow(44e-6, drop, 0.0292, 0.02075) == pytest.approx(7.81813e-5, rel=1e-5)


@given(st.floats(-1e-3, 1e-3), st.floats(-20e6, 20e6))
def test_control_flow_is_odd_in_opening_and_in_drop(x_v, drop):
    flow = control_flow(x_v, drop, 0.0292, 0.02075)
    assert control_flow(-x_v, drop, 0.0292, 0.02075) == -flow
    assert control_flow(x_v, -drop, 0.0292, 0.02075) == -flow


def test_a_chamber_above_supply_pressure_flows_back():
    drop = chamber_1_orifice_drop(44e-6, 20e6, 17.2e6, 0.0)
    assert control_flow(44e-6, drop, 0.0292, 0.02075) < 0.0


def test_a_closed_valve_passes_nothing():
    assert control_flow(0.0, 8.6e6, 0.0292, 0.02075) == 0.0


@given(st.floats(-1e8, 1e8))
def test_the_signed_root_is_the_odd_inverse_of_the_signed_square(value):
    root = float(signed_root(value))
    assert root * abs(root) == pytest.approx(value, rel=1e-14, abs=1e-300)
    assert float(signed_root(-value)) == -root


def test_the_signed_root_takes_arrays():
    np.testing.assert_array_equal(signed_root(np.array([-4.0, 0.0, 9.0])), [-2.0, 0.0, 3.0])


def test_the_spool_rests_where_the_gain_puts_it():
    omega = 2.0 * math.pi * 175.0
    assert spool_acceleration(22e-6 * 2.0, 0.0, 2.0, omega, 0.7, 22e-6) == pytest.approx(0.0, abs=1e-12)
    assert spool_acceleration(0.0, 0.0, 2.0, omega, 0.7, 22e-6) == pytest.approx(omega**2 * 44e-6)


def test_the_spool_is_damped_by_its_speed():
    omega = 2.0 * math.pi * 175.0
    assert spool_acceleration(0.0, 0.01, 0.0, omega, 0.7, 22e-6) == pytest.approx(-2 * 0.7 * omega * 0.01)
