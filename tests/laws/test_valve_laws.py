"""Laws of the servovalve, seen through the simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion

from hydrofdi.config import RunParameters
from hydrofdi.simulation.drive import Drive, Spools


def _spool(step: float, ratio: float = 0.7, duration: float = 0.02) -> tuple[np.ndarray, np.ndarray]:
    parameters = RunParameters().with_values(
        {"run.step": step, "run.sampling_frequency": round(1.0 / step), "valve.damping_ratio": ratio}
    )
    n_step = round(duration / step)
    _, stages = Spools([Drive.of(parameters)], parameters.run).advance(0, n_step)
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
