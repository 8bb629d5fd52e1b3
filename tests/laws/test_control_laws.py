"""Laws of position control."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.physics.control import pid_step
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.batch import simulate_batch

LOOP = RunParameters().with_values(
    {
        "record.duration": 8.0, "input.period": 8.0, "control.law": "p", "control.amplitude": 5e-3,
        "control.proportional_gain": 60.0, "friction.scale": 0.1,
    }
)  # fmt: skip


def simulate(values: dict[str, Any], coefficient: float = 2e-9) -> Trajectory:
    return simulate_batch([LOOP.with_values(values)], [coefficient])


def settled_error(trajectory: Trajectory) -> float:
    error = trajectory.reference_position[0] - trajectory.piston_position[0]
    return float(np.mean(error[1900:2000]))  # before the reference reverses at 4 s


def test_proportional_control_leaves_an_error_against_a_spring_and_a_leak() -> None:
    trajectory = simulate({})
    error, voltage = settled_error(trajectory), float(trajectory.input_voltage[0, 1950])
    assert error > 1e-4
    assert voltage == pytest.approx(60.0 * error, rel=0.02)


def test_integral_action_takes_the_error_away() -> None:
    proportional = settled_error(simulate({}))
    integral = settled_error(simulate({"control.law": "pi", "control.integral_gain": 200.0}))
    assert abs(integral) < 0.05 * proportional


def test_voltage_never_exceeds_its_limit_and_the_integral_does_not_wind_up() -> None:
    gains = {"control.law": "pi", "control.integral_gain": 400.0, "control.amplitude": 60e-3}
    trajectory = simulate({**gains, "control.voltage_limit": 1.0, "actuator.load_stiffness": 0.0})
    voltage, position = trajectory.input_voltage[0], trajectory.piston_position[0]
    assert np.abs(voltage).max() == 1.0
    assert position[:2000].max() < 1.25 * 60e-3  # 200 V/s · s of wound-up error would overshoot by far


def test_voltage_changes_at_samples_of_the_controller_alone() -> None:
    values = {"control.sample_time": 10e-3, "record.sampling_frequency": 1000.0}
    voltage = simulate(values).input_voltage[0].reshape(-1, 10)
    assert np.all(voltage == voltage[:, :1])
    assert np.unique(voltage).size > 100


def test_controllers_of_different_sample_times_share_a_batch_and_stay_themselves() -> None:
    runs = [LOOP.with_values({"control.sample_time": time}) for time in (1e-3, 2e-3, 10e-3)]
    together = simulate_batch(runs, [2e-9] * 3)
    for k, run in enumerate(runs):
        np.testing.assert_array_equal(
            together.piston_position[k], simulate_batch([run], [2e-9]).piston_position[0]
        )
    assert np.ptp(together.piston_position[:, 100]) > 0.0


def test_derivative_part_answers_to_the_change_of_the_error() -> None:
    voltage, _ = pid_step(3e-3, 1e-3, 0.0, 0.0, 0.0, 0.5, 2e-3, 5.0)
    assert voltage == pytest.approx(0.5 * 2e-3 / 2e-3)


def test_limited_integral_is_released_by_an_error_of_the_other_sign() -> None:
    wound = pid_step(1e-2, 1e-2, 4.9, 100.0, 50.0, 0.0, 2e-3, 5.0)
    released = pid_step(-1e-2, 1e-2, 7.0, 100.0, 50.0, 0.0, 2e-3, 5.0)
    assert wound == (5.0, 4.9)
    assert released == (5.0, pytest.approx(7.0 - 1e-3))
