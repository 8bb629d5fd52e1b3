import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.physics.cylinder import chamber_pressure_rates, piston_acceleration
from hydrofdi.physics.hydraulic_mode import (
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    valve_flow_pressure_coefficient,
)
from hydrofdi.physics.leakage import external_leakage_flow, internal_leakage_flow

AREA, VOLUME, MASS, BETA, STIFFNESS = 633e-6, 280e-6, 12.3, 551e6, 150e3
flows = st.floats(-1e-3, 1e-3)
positions = st.floats(-0.3, 0.3)


def test_the_piston_obeys_newton_by_hand():
    # (633e-6·(10e6 − 6e6) − 205 − 150e3·0.01)/12.3 = (2532 − 205 − 1500)/12.3
    acceleration = piston_acceleration(0.01, 10e6, 6e6, 205.0, MASS, AREA, STIFFNESS)
    assert acceleration == pytest.approx(827.0 / 12.3, rel=1e-12)


def test_equal_pressures_leave_a_centred_frictionless_piston_at_rest():
    assert piston_acceleration(0.0, 8e6, 8e6, 0.0, MASS, AREA, STIFFNESS) == 0.0


@given(positions, flows, flows)
def test_each_chamber_is_stiffer_the_smaller_it_is(x, net_1, net_2):
    rates = chamber_pressure_rates(x, net_1, net_2, BETA, VOLUME, AREA)
    assert rates[0] == pytest.approx(BETA / (VOLUME + AREA * x) * net_1, rel=1e-12, abs=1e-300)
    assert rates[1] == pytest.approx(BETA / (VOLUME - AREA * x) * net_2, rel=1e-12, abs=1e-300)


@given(positions, flows, flows)
def test_mirrored_chambers_swap_their_rates(x, net_1, net_2):
    rates = chamber_pressure_rates(x, net_1, net_2, BETA, VOLUME, AREA)
    mirrored = chamber_pressure_rates(-x, net_2, net_1, BETA, VOLUME, AREA)
    assert mirrored == pytest.approx(rates[::-1], rel=1e-14, abs=1e-300)


@given(st.floats(-20e6, 20e6), st.floats(0.0, 1e-6))
def test_internal_leakage_is_odd_in_the_pressure_difference(difference, coefficient):
    flow = internal_leakage_flow(difference, coefficient)
    assert internal_leakage_flow(-difference, coefficient) == -flow
    assert flow * difference >= 0.0


def test_internal_leakage_follows_the_orifice_law():
    assert internal_leakage_flow(4e6, 1e-8) == pytest.approx(2e-5, rel=1e-14)
    assert internal_leakage_flow(16e6, 1e-8) == pytest.approx(4e-5, rel=1e-14)
    assert internal_leakage_flow(0.0, 1e-8) == 0.0


def test_external_leakage_is_proportional_to_pressure():
    assert external_leakage_flow(8e6, 1e-13) == pytest.approx(8e-7, rel=1e-14)


def test_the_mode_of_the_nominal_actuator_by_hand():
    # √(2·551e6·(633e-6)²/(280e-6·12.3) + 150e3/12.3) = √(128212.0 + 12195.1) = 374.709… rad/s
    assert mode_frequency(BETA, AREA, VOLUME, MASS, STIFFNESS) == pytest.approx(374.709, abs=2e-3)


def test_without_fluid_stiffness_the_spring_alone_rules_the_mode():
    assert mode_frequency(1e-30, AREA, VOLUME, MASS, STIFFNESS) == pytest.approx(math.sqrt(STIFFNESS / MASS))


def test_leakage_damps_the_mode_and_the_frequency_does_not_change():
    omega = mode_frequency(BETA, AREA, VOLUME, MASS, STIFFNESS)
    sealed, leaky = (mode_damping_ratio(omega, BETA, VOLUME, MASS, 50.0, 1e-12, G) for G in (0.0, 1e-12))
    assert leaky - sealed == pytest.approx(BETA * 2e-12 / (2 * VOLUME * omega), rel=1e-12)


@given(st.floats(1e5, 17e6))
def test_conductances_are_the_slopes_of_the_flows(drop):
    step = 1e-4 * drop
    leakage = [internal_leakage_flow(drop + side * step, 1e-8) for side in (-1, 1)]
    assert leakage_conductance(drop, 1e-8) == pytest.approx((leakage[1] - leakage[0]) / (2 * step), rel=1e-6)
    slope = valve_flow_pressure_coefficient(44e-6, drop, 0.0292, 0.02075)
    assert slope == pytest.approx(leakage_conductance(drop, 0.0292 * 0.02075 * 44e-6), rel=1e-12)
