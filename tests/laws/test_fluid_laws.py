"""Laws of the fluid and of the supply."""

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import RunParameters
from hydrofdi.physics.fluid import (
    LEAST_ABSOLUTE_PRESSURE,
    OILS,
    effective_bulk_modulus,
    stiffening_bulk_modulus,
)
from hydrofdi.physics.hydraulic_mode import mode_frequency
from hydrofdi.physics.valve import control_flow
from hydrofdi.quality.machine import hydraulic_mode, step_limits
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.hydraulics import lane_parameters
from hydrofdi.simulation.lanes import ModelOptions, pack_singles
from tests.machines import GAP, machine

LIQUID, AIR, EXPONENT, ATMOSPHERE = 1.4e9, 0.01, 1.4, 101325.0
pressures = st.floats(min_value=-0.9e5, max_value=40e6)
NOMINAL = RunParameters()


def test_modulus_tends_to_that_of_the_gas_as_the_pressure_vanishes() -> None:
    absolute = np.array([1e5, 1e4, LEAST_ABSOLUTE_PRESSURE])
    modulus = effective_bulk_modulus(absolute - ATMOSPHERE, LIQUID, AIR, EXPONENT, ATMOSPHERE)
    share_of_liquid = 1.0 / (1.0 + AIR * (ATMOSPHERE / absolute) ** (1.0 / EXPONENT))
    np.testing.assert_allclose(modulus * (1.0 - share_of_liquid), EXPONENT * absolute, rtol=0.02)


@given(pressures, st.floats(min_value=1e-4, max_value=0.1), st.floats(min_value=1.0, max_value=1.4))
def test_modulus_is_minus_the_volume_over_its_slope(pressure: float, air: float, exponent: float) -> None:
    def volume(at: float) -> float:
        gas = air * (ATMOSPHERE / (at + ATMOSPHERE)) ** (1.0 / exponent)
        return math.exp(-at / LIQUID) + gas

    step = 1e-4 * (pressure + ATMOSPHERE)
    slope = (volume(pressure + step) - volume(pressure - step)) / (2.0 * step)
    modulus = effective_bulk_modulus(pressure, LIQUID, air, exponent, ATMOSPHERE)
    assert modulus == pytest.approx(-volume(pressure) / slope, rel=1e-5)


def test_piston_rings_at_the_frequency_of_the_softened_fluid() -> None:
    """With all ports shut, the mode of a small ring-down follows β at the mean pressure."""
    step, mean = 2e-5, 0.5 * NOMINAL.supply.pressure
    air = {"fluid.free_air": 0.05}
    values = [{"actuator.load_stiffness": 0.0, **FRICTIONLESS, **law} for law in ({}, air)]
    motion = free_motion(values, [{"velocity": 1e-4}] * 2, [0.0], 0.2, step)
    moduli = (551e6, effective_bulk_modulus(mean, 551e6, 0.05, 1.4, 101325.0))
    for velocity, modulus in zip(motion["velocity"], moduli, strict=True):
        rises = np.flatnonzero((velocity[:-1] <= 0.0) & (velocity[1:] > 0.0))
        frequency = 2.0 * math.pi * (len(rises) - 1) / (step * (rises[-1] - rises[0]))
        assert frequency == pytest.approx(
            mode_frequency(modulus, (633e-6, 633e-6), (280e-6, 280e-6), 12.3, 0.0), rel=2e-3
        )


SLOPE = {"fluid.bulk_modulus_pressure_slope": 11.0}


def test_shut_chambers_follow_the_closed_form_of_a_liquid_that_stiffens() -> None:
    """V = V_0 (1 + m P/β_0)^(−1/m) while a piston is thrown against shut ports; from 2 to 16 MPa."""
    free = {"actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.4e9, **FRICTIONLESS, **SLOPE}
    motion = free_motion([free], [{"velocity": 1.2}], [0.0], 0.02, 1e-5)
    for number, sign in ((1, 1.0), (2, -1.0)):
        pressure = motion[f"pressure_{number}"][0]
        assert np.ptp(pressure) > 12e6
        assert pressure.min() > 1e6
        volume = 280e-6 + sign * 633e-6 * motion["position"][0]
        oil = volume * (1.0 + 11.0 * pressure / 1.4e9) ** (1.0 / 11.0)
        np.testing.assert_allclose(oil, oil[0], rtol=1e-9)


def test_slope_is_that_of_mineral_oils() -> None:
    """A constant slope of 10.6 is within 1 % of the tangent modulus of Hayward, up to 400 bar."""
    oil, pressures = OILS["HLP46"], np.linspace(0.0, 40e6, 21)
    for temperature in (293.15, 318.15, 343.15):
        tangent = [oil.bulk_modulus(temperature, pressure) for pressure in pressures.tolist()]
        np.testing.assert_allclose(stiffening_bulk_modulus(pressures, tangent[0], 10.6), tangent, rtol=0.01)


@given(pressures, st.floats(min_value=1e-4, max_value=0.1))
def test_oil_with_air_that_stiffens_is_minus_the_volume_over_its_slope(pressure: float, air: float) -> None:
    def volume(at: float) -> float:
        liquid = (1.0 + 11.0 * max(at, 0.0) / LIQUID) ** (-1.0 / 11.0) * math.exp(-min(at, 0.0) / LIQUID)
        return liquid + air * (ATMOSPHERE / (at + ATMOSPHERE)) ** (1.0 / EXPONENT)

    step = 1e-4 * (pressure + ATMOSPHERE)
    slope = (volume(pressure + step) - volume(pressure - step)) / (2.0 * step)
    liquid = stiffening_bulk_modulus(pressure, LIQUID, 11.0)
    modulus = effective_bulk_modulus(pressure, liquid, air, EXPONENT, ATMOSPHERE)
    assert modulus == pytest.approx(-volume(pressure) / slope, rel=2e-4)


def test_stiffer_oil_raises_the_mode_and_shortens_the_step() -> None:
    short, stiff = machine({}), machine(SLOPE)
    modes = [hydraulic_mode(one, simulate_batch([one], [0.0])).frequency for one in (stiff, short)]
    spring = mode_frequency(0.0, (633e-6, 633e-6), (280e-6, 280e-6), 12.3, 150e3) ** 2
    squares = [(2.0 * math.pi * each) ** 2 - spring for each in modes]
    assert squares[0] / squares[1] == pytest.approx(1.0 + 11.0 * 8.6e6 / 551e6, rel=0.01)
    limits = [step_limits(lambda *_, run=run: [run])["hydraulic mode"] for run in (stiff, short)]
    ratio = (limits[1] / limits[0]) ** 2
    assert 1.0 + 11.0 * 8.6e6 / 551e6 < ratio < 1.0 + 11.0 * 17.2e6 / 551e6


def test_stored_mode_is_that_of_the_softened_fluid() -> None:
    short, soft = machine({}), machine({"fluid.free_air": 0.05})
    modes = [hydraulic_mode(one, simulate_batch([one], [0.0])) for one in (soft, short)]
    assert modes[0].frequency < 0.995 * modes[1].frequency


RESISTANCE, TIME_CONSTANT, OPENING = 4e10, 0.02, 44e-6
DROOP = {"supply.droop_resistance": RESISTANCE, "supply.droop_time_constant": TIME_CONSTANT}
HELD = {**DROOP, "actuator.load_stiffness": 0.0, "leakage.internal_coefficient": 5e-9}


def test_supply_settles_where_its_fall_is_resistance_times_flow_in_both_directions() -> None:
    motion = free_motion([HELD, HELD], [{}, {}], [OPENING, -OPENING], 0.5, 1e-4)
    np.testing.assert_allclose(motion["supply"][0], motion["supply"][1], rtol=1e-9)
    supply, pressure_1 = motion["supply"][0, -1000:].mean(), motion["pressure_1"][0, -1000:].mean()
    flow = control_flow(OPENING, supply - pressure_1, NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient)
    np.testing.assert_allclose(17.2e6 - supply, RESISTANCE * flow, rtol=2e-3)
    assert 17.2e6 - supply > 1e6


def test_supply_recovers_with_its_time_constant() -> None:
    motion = free_motion([DROOP], [{"supply": 15e6}], [0.0], 0.1, 1e-4)
    time = 1e-4 * np.arange(motion["supply"].shape[1])
    np.testing.assert_allclose(motion["supply"][0], 17.2e6 - 2.2e6 * np.exp(-time / TIME_CONSTANT), rtol=1e-9)


def test_supply_without_resistance_is_constant() -> None:
    short = NOMINAL.with_values({"record.duration": 1.0, "input.period": 0.5})
    trajectory = simulate_batch([short, machine({})], [1e-9, 1e-9])
    np.testing.assert_allclose(trajectory.valve_supply_pressure[1], 17.2e6, rtol=1e-15)
    np.testing.assert_allclose(*trajectory.chamber_1_pressure, rtol=1e-9)


def test_open_underlapped_valve_draws_its_centre_flow_from_the_supply() -> None:
    """With the spool centred, each chamber sits halfway, and P_s − R q_s with q_s of two edges."""
    lap = 5e-6
    motion = free_motion([{**DROOP, "valve.lap": -lap}], [{}], [0.0], 8.0, 1e-4)
    supply, pressure_1 = motion["supply"][0, -1], motion["pressure_1"][0, -1]
    assert abs(pressure_1 / supply - 0.5) < 1e-6
    gain = NOMINAL.valve.flow_gain * NOMINAL.valve.area_gradient
    flow = 2.0 * gain * lap * math.sqrt(0.5 * supply)
    np.testing.assert_allclose(17.2e6 - supply, RESISTANCE * flow, rtol=1e-6)


@pytest.mark.parametrize("droop", ["none", "first_order"])
def test_pump_adds_a_sine_to_the_supply(droop) -> None:
    values = {"supply.droop": droop, "supply.ripple": 0.01, "supply.ripple_frequency": 100.0}
    motion = free_motion([values], [{}], [44e-6], 0.5, 2e-5)
    time = 2e-5 * np.arange(motion["supply"].shape[1])
    settled = time > (0.3 if droop == "first_order" else 0.0)
    sine = 17.2e6 * (1.0 + 0.01 * np.sin(2.0 * np.pi * 100.0 * time))
    # the droop lets 1/(ωτ) of it decay
    atol = 0.04 * 0.172e6 if droop == "first_order" else 1e-4 * 0.172e6
    np.testing.assert_allclose(motion["supply"][0, settled], sine[settled], rtol=0.0, atol=atol)


def test_return_pressure_rises_by_resistance_times_flow_with_its_time_constant() -> None:
    line = {
        "supply.return_pressure": 0.4e6, "supply.return_resistance": 2e9,
        "supply.return_time_constant": 0.02,
    }  # fmt: skip
    held = line | {"actuator.load_stiffness": 0.0, "leakage.internal_coefficient": 5e-9}
    motion = free_motion([held, held], [{}, {}], [OPENING, -OPENING], 0.5, 1e-4)
    pressure, drained = motion["return_pressure"][0, -1000:].mean(), motion["pressure_2"][0, -1000:].mean()
    flow = control_flow(OPENING, drained - pressure, NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient)
    np.testing.assert_allclose(pressure - 0.4e6, 2e9 * flow, rtol=2e-3)
    np.testing.assert_allclose(*motion["return_pressure"], rtol=1e-9)
    falling = free_motion([line], [{"return_pressure": 1.4e6}], [0.0], 0.1, 1e-4)["return_pressure"][0]
    expected = 0.4e6 + 1e6 * np.exp(-1e-4 * np.arange(falling.size) / 0.02)
    np.testing.assert_allclose(falling, expected, rtol=1e-8)


WARM = {"fluid.temperature_rise": 10.0, "fluid.temperature_drift": 2.0}


def test_warm_oil_is_a_run_with_a_lower_modulus_and_thinner_oil() -> None:
    """A constant rise changes β by e^(k θ), viscous friction by e^(k θ), laminar flows by its inverse."""
    own = {"fluid.bulk_modulus": 551e6, "friction.viscous": 50.0}
    laminar = {
        "valve.lap_leakage": 4e-14, "supply_1_edge.lap_leakage": 2e-14, "leakage.external_coefficient": 1e-13,
    }  # fmt: skip
    thin, soft = math.exp(-0.03 * 10.0), math.exp(-0.005 * 10.0)
    warm = machine(own | laminar | {"fluid.temperature_rise": 10.0}, GAP)
    other = {"fluid.bulk_modulus": 551e6 * soft, "friction.viscous": 50.0 * thin}
    same = machine({name: value / thin for name, value in laminar.items()} | other, GAP)
    pressure = simulate_batch([warm, same], [2e-9, 2e-9 / thin]).chamber_1_pressure
    np.testing.assert_allclose(pressure[0], pressure[1], rtol=1e-7)


def test_orifice_leak_does_not_depend_on_temperature_and_a_drift_begins_at_the_rise() -> None:
    run = NOMINAL.with_values({**WARM, "record.duration": 1.0, "input.period": 0.5})
    singles, options = pack_singles([run], [3e-9]), ModelOptions.of(run)
    for time in (0.0, 5.0):
        p = lane_parameters(singles.view(np.recarray)[0], 0, time, time, options)
        assert p.internal_leakage == 3e-9
        assert p.viscous == pytest.approx(50.0 * math.exp(-0.03 * (10.0 + 2.0 * time)), rel=1e-11)
        assert p.bulk_modulus == pytest.approx(551e6 * math.exp(-0.005 * (10.0 + 2.0 * time)), rel=1e-11)
