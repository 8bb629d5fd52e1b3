"""Laws of the fluid and of the supply."""

import math

import numpy as np
import pytest
from free_motion import FREE, FRICTIONLESS, free_motion, ring_down

from hydrofdi.config import RunParameters
from hydrofdi.physics.fluid import OILS, effective_bulk_modulus, stiffening_bulk_modulus
from hydrofdi.physics.hydraulic_mode import mode_frequency
from hydrofdi.physics.valve import control_flow
from hydrofdi.quality.machine import hydraulic_mode, step_limits
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.hydraulics import lane_parameters
from hydrofdi.simulation.lanes import ModelOptions, pack_singles
from tests.machines import GAP, machine

ATMOSPHERE = 101325.0
NOMINAL = RunParameters()
GAIN = NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient
SLOPE, AIR = {"fluid.bulk_modulus_pressure_slope": 11.0}, {"fluid.free_air": 0.05}


def test_slope_is_that_of_mineral_oils() -> None:
    """A constant slope of 10.6 is within 1 % of the tangent modulus of Hayward, up to 400 bar."""
    oil, pressures = OILS["HLP46"], np.linspace(0.0, 40e6, 21)
    for temperature in (293.15, 318.15, 343.15):
        tangent = [oil.bulk_modulus(temperature, pressure) for pressure in pressures.tolist()]
        np.testing.assert_allclose(stiffening_bulk_modulus(pressures, tangent[0], 10.6), tangent, rtol=0.01)
    assert stiffening_bulk_modulus(-1e5, 1.4e9, 11.0) == 1.4e9


def _mode(modulus: float, stiffness: float) -> float:
    return mode_frequency(modulus, (633e-6, 633e-6), (280e-6, 280e-6), 12.3, stiffness)


def test_piston_rings_at_the_frequency_of_its_fluid_which_is_stored_and_limits_the_step() -> None:
    """With all ports shut, the mode of a small ring-down follows β at the mean pressure."""
    mean, laws = 0.5 * NOMINAL.supply.pressure, [{}, AIR, SLOPE]
    moduli = [551e6, effective_bulk_modulus(mean, 551e6, 0.05, 1.4, ATMOSPHERE), 551e6 + 11.0 * mean]
    values = [FREE | FRICTIONLESS | law for law in laws]
    motion = free_motion(values, [{"velocity": 1e-4}] * 3, [0.0], 0.2, 2e-5)
    limits = []
    for law, velocity, modulus in zip(laws, motion["velocity"], moduli, strict=True):
        assert ring_down(velocity, 2e-5)[0] == pytest.approx(_mode(modulus, 0.0), rel=2e-3)
        run = machine(law)
        stored = 2.0 * math.pi * hydraulic_mode(run, simulate_batch([run], [0.0])).frequency
        assert stored == pytest.approx(_mode(modulus, 150e3), rel=2e-3)
        limits.append(step_limits(lambda *_, run=run: [run])["hydraulic mode"])
    assert moduli[2] / 551e6 < (limits[0] / limits[2]) ** 2 < 1.0 + 2.0 * (moduli[2] / 551e6 - 1.0)


def test_shut_chambers_follow_the_closed_form_of_a_liquid_that_stiffens() -> None:
    """V = V_0 (1 + m P/β_0)^(−1/m) while a piston is thrown against shut ports; from 2 to 16 MPa."""
    values = FREE | FRICTIONLESS | SLOPE | {"fluid.bulk_modulus": 1.4e9}
    motion = free_motion([values], [{"velocity": 1.2}], [0.0], 0.02, 1e-5)
    for number, sign in ((1, 1.0), (2, -1.0)):
        pressure = motion[f"pressure_{number}"][0]
        assert np.ptp(pressure) > 12e6
        volume = 280e-6 + sign * 633e-6 * motion["position"][0]
        oil = volume * (1.0 + 11.0 * pressure / 1.4e9) ** (1.0 / 11.0)
        np.testing.assert_allclose(oil, oil[0], rtol=1e-9)


LINES = {
    "supply.droop_resistance": 4e10, "supply.droop_time_constant": 0.02, "supply.return_pressure": 0.4e6,
    "supply.return_resistance": 2e9, "supply.return_time_constant": 0.03,
}  # fmt: skip


def test_supply_and_return_differ_from_rest_by_resistance_times_flow_in_both_directions() -> None:
    values, opening = LINES | FREE | {"leakage.internal_coefficient": 5e-9}, 44e-6
    motion = free_motion([values] * 2, [{}, {}], [opening, -opening], 0.5, 1e-4)
    end = {name: signal[:, -1000:].mean(axis=1) for name, signal in motion.items()}
    np.testing.assert_allclose(*motion["supply"], rtol=1e-9)
    np.testing.assert_allclose(*motion["return_pressure"], rtol=1e-9)
    fed = control_flow(opening, end["supply"][0] - end["pressure_1"][0], *GAIN)
    drained = control_flow(opening, end["pressure_2"][0] - end["return_pressure"][0], *GAIN)
    np.testing.assert_allclose(17.2e6 - end["supply"], 4e10 * fed, rtol=2e-3)
    np.testing.assert_allclose(end["return_pressure"] - 0.4e6, 2e9 * drained, rtol=2e-3)


def test_supply_and_return_recover_with_their_time_constants() -> None:
    start = {"supply": 15e6, "return_pressure": 1.4e6}
    motion, time = free_motion([LINES], [start], [0.0], 0.1, 1e-4), 1e-4 * np.arange(1000)
    np.testing.assert_allclose(motion["supply"][0], 17.2e6 - 2.2e6 * np.exp(-time / 0.02), rtol=1e-8)
    np.testing.assert_allclose(motion["return_pressure"][0], 0.4e6 + 1e6 * np.exp(-time / 0.03), rtol=1e-8)


def test_open_edges_draw_their_centre_flow_from_the_supply() -> None:
    """With the spool centred, chambers sit halfway, and P_s − R q_s with q_s of two edges; rounding opens
    an edge by half its radius.
    """
    droop = {"supply.droop_resistance": 4e10, "supply.droop_time_constant": 0.02}
    own = [{"valve.lap": -5e-6}, {"valve.edge_rounding": 10e-6}]
    motion = free_motion([droop | each for each in own], [{}, {}], [0.0, 0.0], 8.0, 1e-4)
    supply = motion["supply"][:, -1]
    np.testing.assert_allclose(motion["pressure_1"][:, -1] / supply, 0.5, atol=1e-6)
    flow = 2.0 * control_flow(5e-6, 0.5 * supply, *GAIN)
    np.testing.assert_allclose(17.2e6 - supply, 4e10 * flow, rtol=1e-6)


@pytest.mark.parametrize("droop", ["none", "first_order"])
def test_pump_adds_a_sine_to_the_supply(droop) -> None:
    values = {"supply.droop": droop, "supply.ripple": 0.01, "supply.ripple_frequency": 100.0}
    motion = free_motion([values], [{}], [44e-6], 0.5, 2e-5)
    time = 2e-5 * np.arange(motion["supply"].shape[1])
    sine = 17.2e6 * (1.0 + 0.01 * np.sin(2.0 * np.pi * 100.0 * time))
    settled, share = (time > 0.3, 0.04) if droop == "first_order" else (time > 0.0, 1e-4)  # 1/(ωτ) decays
    np.testing.assert_allclose(motion["supply"][0, settled], sine[settled], rtol=0.0, atol=share * 0.172e6)


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
    run = NOMINAL.with_values({"fluid.temperature_rise": 10.0, "fluid.temperature_drift": 2.0})
    singles, options = pack_singles([run], [3e-9]), ModelOptions.of(run)
    for time in (0.0, 5.0):
        p = lane_parameters(singles.view(np.recarray)[0], 0, time, time, options)
        assert p.internal_leakage == 3e-9
        assert p.viscous == pytest.approx(50.0 * math.exp(-0.03 * (10.0 + 2.0 * time)), rel=1e-11)
        assert p.bulk_modulus == pytest.approx(551e6 * math.exp(-0.005 * (10.0 + 2.0 * time)), rel=1e-11)
