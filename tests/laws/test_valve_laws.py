"""Laws of the servovalve, seen through the simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion

from hydrofdi.config import RunParameters
from hydrofdi.physics.hydraulic_mode import valve_flow_pressure_coefficient
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow, edge_flow
from hydrofdi.simulation.drive import Drive, Spools


def _spool(
    step: float, ratio: float = 0.7, duration: float = 0.02, **limits: float
) -> tuple[np.ndarray, np.ndarray]:
    valve = {"valve.damping_ratio": ratio} | {f"valve.{name}": value for name, value in limits.items()}
    parameters = RunParameters().with_values(
        {"record.step": step, "record.sampling_frequency": round(1.0 / step), **valve}
    )
    n_step = round(duration / step)
    _, stages = Spools([Drive.of(parameters)], parameters.record).advance(0, n_step)
    return step * np.arange(n_step), stages[:, 0, 0]


def _second_order_step(time: np.ndarray, ratio: float) -> np.ndarray:
    omega, final = 2.0 * math.pi * 175.0, 22e-6 * 2.0
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = np.cos(damped * time) + ratio * omega / damped * np.sin(damped * time)
    return final * (1.0 - np.exp(-ratio * omega * time) * wave)


@pytest.mark.parametrize("ratio", [0.3, 0.7])
def test_spool_follows_a_voltage_step_like_a_second_order_lag(ratio: float) -> None:
    time, position = _spool(1e-4, ratio)
    np.testing.assert_allclose(position, _second_order_step(time, ratio), atol=1e-5 * 44e-6)


def test_spool_error_falls_with_the_fourth_power_of_the_step() -> None:
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        time, position = _spool(step)
        errors.append(np.abs(position - _second_order_step(time, 0.7)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 4.0) < 0.3)


def test_free_piston_runs_at_the_no_load_flow_over_its_area() -> None:
    parameters, opening = RunParameters(), 44e-6
    values = {"actuator.load_stiffness": 0.0, **FRICTIONLESS, "friction.viscous": 1.0}
    values |= {"leakage.internal_coefficient": 5e-9}  # damps the start
    motion = free_motion([values, values], [{}, {}], [opening, -opening], 0.4, 1e-4)
    valve, drop = parameters.valve, 0.5 * parameters.supply.pressure
    speed = (
        valve.flow_gain * valve.area_gradient * opening * math.sqrt(drop) / parameters.actuator.piston_area
    )
    np.testing.assert_allclose(motion["velocity"][:, -200:].mean(axis=1), [speed, -speed], rtol=1e-2)


def test_mirrored_opening_gives_mirrored_motion() -> None:
    motion = free_motion([{}, {}], [{}, {}], [44e-6, -44e-6], 0.3, 1e-4)
    np.testing.assert_allclose(motion["position"][0], -motion["position"][1], atol=1e-12)
    np.testing.assert_allclose(motion["pressure_1"][0], motion["pressure_2"][1], rtol=1e-9)


def test_saturated_spool_stops_at_its_largest_opening() -> None:
    _, position = _spool(1e-4, 0.3, largest_opening=30e-6)
    assert position.max() == 30e-6
    assert position[-1] == pytest.approx(30e-6, rel=0.05)


def test_slow_spool_travels_at_its_largest_speed() -> None:
    time, position = _spool(1e-4, largest_speed=5e-3)
    cruising = (time > 2e-3) & (time < 6e-3)
    np.testing.assert_allclose(np.diff(position[cruising]), 5e-3 * 1e-4, rtol=1e-9)
    assert position[-1] == pytest.approx(44e-6, rel=0.02)


GAIN = (RunParameters().valve.flow_gain, RunParameters().valve.area_gradient)


@pytest.mark.parametrize("opening", [-44e-6, -1e-6, 0.0, 20e-6])
@pytest.mark.parametrize("pressure", [-1e6, 3e6, 8e6, 18e6])
def test_critically_lapped_edges_are_the_orifices_of_the_paper(opening: float, pressure: float) -> None:
    supply, ret = 17.2e6, 0.2e6
    q_1 = edge_flow(opening, supply - pressure, *GAIN, 0.0, 0.0)
    q_1 -= edge_flow(-opening, pressure - ret, *GAIN, 0.0, 0.0)
    q_2 = edge_flow(opening, pressure - ret, *GAIN, 0.0, 0.0)
    q_2 -= edge_flow(-opening, supply - pressure, *GAIN, 0.0, 0.0)
    drop_1 = chamber_1_orifice_drop(opening, pressure, supply, ret)
    drop_2 = chamber_2_orifice_drop(opening, pressure, supply, ret)
    assert q_1 == pytest.approx(control_flow(opening, drop_1, *GAIN), rel=1e-12, abs=1e-20)
    assert q_2 == pytest.approx(control_flow(opening, drop_2, *GAIN), rel=1e-12, abs=1e-20)


def test_overlapped_valve_does_not_move_the_piston_within_its_dead_band() -> None:
    values = {"valve.lap": 5e-6, "actuator.load_stiffness": 0.0}
    motion = free_motion([values] * 2, [{}] * 2, [4.9e-6, 15e-6], 0.2, 1e-4)
    assert np.abs(motion["position"][0]).max() < 1e-9
    assert motion["position"][1, -1] > 1e-3


def test_lap_leakage_alone_brings_shut_chambers_to_half_the_supply() -> None:
    """Clearances to supply and return halve the pressure; each chamber fills with V/(2 β c_lap)."""
    values = {"valve.lap": 5e-6, "valve.lap_leakage": 5e-13, "fluid.bulk_modulus": 551e6}
    start = {"pressure_1": 2e6, "pressure_2": 2e6}
    motion = free_motion([values], [start], [0.0], 1.0, 1e-4)
    time = 1e-4 * np.arange(motion["pressure_1"].shape[1])
    constant = 280e-6 / (2.0 * 551e6 * 5e-13)
    expected = 8.6e6 - 6.6e6 * np.exp(-time / constant)
    np.testing.assert_allclose(motion["pressure_1"][0], expected, rtol=1e-6)


def test_underlap_damps_the_hydraulic_mode() -> None:
    """Both edges of a port stand open by x_0: K_c is twice that of one, and the decay rate β K_c/(2V)."""
    lap, beta, volume, seconds = 4e-6, 551e6, 280e-6, 1.0
    values = {**FRICTIONLESS, "actuator.load_stiffness": 0.0, "valve.lap": -lap}
    velocity = free_motion([values], [{"velocity": 1e-3}], [0.0], seconds, 2e-5)["velocity"][0]
    peaks = [np.abs(part).max() for part in np.split(velocity, 50)]
    coefficient = 2.0 * valve_flow_pressure_coefficient(lap, 8.6e6, *GAIN)
    rate = math.log(peaks[5] / peaks[45]) / (seconds * 40 / 50)
    assert rate == pytest.approx(beta * coefficient / (2.0 * volume), rel=0.02)
