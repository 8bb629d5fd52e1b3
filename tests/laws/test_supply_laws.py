"""Laws of a supply that gives way to flow."""

from __future__ import annotations

import math

import numpy as np
from free_motion import free_motion

from hydrofdi.config import RunParameters
from hydrofdi.physics.valve import control_flow
from hydrofdi.simulation.batch import simulate_batch

RESISTANCE, TIME_CONSTANT, OPENING = 4e10, 0.02, 44e-6
DROOP = {
    "supply.droop": "first_order", "supply.droop_resistance": RESISTANCE,
    "supply.droop_time_constant": TIME_CONSTANT,
}  # fmt: skip
HELD = {**DROOP, "actuator.load_stiffness": 0.0, "leakage.internal_coefficient": 5e-9}
NOMINAL = RunParameters()


def test_supply_settles_where_its_fall_is_resistance_times_flow() -> None:
    motion = free_motion([HELD], [{}], [OPENING], 0.5, 1e-4)
    supply, pressure_1 = motion["supply"][0, -1000:].mean(), motion["pressure_1"][0, -1000:].mean()
    flow = control_flow(OPENING, supply - pressure_1, NOMINAL.valve.flow_gain, NOMINAL.valve.area_gradient)
    np.testing.assert_allclose(17.2e6 - supply, RESISTANCE * flow, rtol=2e-3)
    assert 17.2e6 - supply > 1e6


def test_supply_recovers_with_its_time_constant() -> None:
    motion = free_motion([DROOP], [{"supply": 15e6}], [0.0], 0.1, 1e-4)
    time = 1e-4 * np.arange(motion["supply"].shape[1])
    np.testing.assert_allclose(motion["supply"][0], 17.2e6 - 2.2e6 * np.exp(-time / TIME_CONSTANT), rtol=1e-9)


def test_both_directions_of_motion_draw_from_the_supply_alike() -> None:
    motion = free_motion([HELD, HELD], [{}, {}], [OPENING, -OPENING], 0.2, 1e-4)
    np.testing.assert_allclose(motion["supply"][0], motion["supply"][1], rtol=1e-9)


def test_supply_without_resistance_is_constant() -> None:
    short = NOMINAL.with_values({"record.duration": 1.0, "input.period": 0.5})
    stiff = short.with_values({"supply.droop": "first_order", "supply.droop_resistance": 0.0})
    trajectory = simulate_batch([short, stiff], [1e-9, 1e-9])
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
