"""Controllers that read the sensor of the position."""

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.sensing import Measurement
from hydrofdi.sensing.measurement import feedback_noise, quantised, saturated
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH
from tests.second_solver import simulate_with_solver

LOOP = RunParameters().with_values(
    {
        "record.duration": 2.0, "input.period": 2.0, "control.law": "p", "control.amplitude": 5e-3,
        "control.proportional_gain": 1.0, "control.feedback": "measured", "friction.scale": 0.1,
    }
)  # fmt: skip
NOISY = {
    "position_sensor.noise": 20e-6, "position_sensor.bias": 1e-4, "position_sensor.drift": 1e-5,
    "position_sensor.lowest": -0.05, "position_sensor.highest": 0.05, "position_sensor.bits": 12,
}  # fmt: skip


def measured(*runs):
    """What happened, and what the sensors show."""
    sensors = Measurement(runs)
    truth = simulate_batch(runs, [2e-9] * len(runs), sensors)
    return truth, sensors.show(truth)


def test_ideal_sensor_in_the_loop_changes_no_bit():
    read, true = simulate_batch(
        [LOOP, LOOP.with_values({"control.feedback": "ideal"})], [2e-9] * 2
    ).input_voltage
    np.testing.assert_array_equal(read, true)


def test_bias_of_the_reading_shifts_the_true_position():
    values = {
        "control.law": "pi", "control.proportional_gain": 100.0, "control.integral_gain": 400.0,
        "actuator.load_stiffness": 0.0, "record.duration": 6.0, "input.period": 12.0,
    }  # fmt: skip
    bias = 1e-3
    runs = [LOOP.with_values(values | {"position_sensor.bias": b}) for b in (0.0, bias)]
    truth, shown = measured(*runs)
    settled = slice(-250, None)
    shift = truth.piston_position[1, settled] - truth.piston_position[0, settled]
    np.testing.assert_allclose(shift, -bias, rtol=0.02)
    np.testing.assert_allclose(shown.piston_position[1, settled], 5e-3, rtol=0.02)


@pytest.mark.parametrize("sample_time", [2e-3, 4e-3, 1e-3])
@pytest.mark.parametrize("pairing", ["independent", "common"])
def test_controller_reads_what_the_record_shows_at_the_same_instants(sample_time, pairing):
    """A law without memory tells what it read: u = K_p (r − x), with K_p = 1 V/m."""
    values = NOISY | {"control.sample_time": sample_time, "measurement.pairing": pairing}
    truth, shown = measured(LOOP.with_values(values))
    every = max(1, round(sample_time * LOOP.record.sampling_frequency))
    read = (truth.reference_position - truth.input_voltage)[0, ::every]
    np.testing.assert_allclose(read, shown.piston_position[0, ::every], atol=1e-12)
    assert np.std(read - truth.piston_position[0, ::every]) > 10e-6


def test_noise_between_the_samples_is_as_strong_and_its_own():
    noise = feedback_noise(LOOP.with_values(NOISY | {"control.sample_time": 0.2e-3}))
    assert noise is not None
    assert noise.size == 10_000
    assert np.std(noise) == pytest.approx(20e-6, rel=0.05)
    correlation = np.corrcoef(noise[1:], noise[:-1])[0, 1]
    assert abs(correlation) < 0.05


def test_density_is_noise_up_to_half_the_rate_of_the_controller():
    values = {
        "position_sensor.noise_density": 1e-6,
        "control.sample_time": 0.2e-3,
        "measurement.anti_alias": 50.0,
    }
    noise = feedback_noise(LOOP.with_values(values))
    assert noise is not None
    assert np.std(noise) == pytest.approx(1e-6 * np.sqrt(0.5 / 0.2e-3), rel=0.05)


def test_reading_leaves_neither_its_range_nor_its_levels():
    truth, _ = measured(LOOP.with_values(NOISY | {"position_sensor.highest": 1e-4}))
    read = (truth.reference_position - truth.input_voltage)[0]
    assert read.max() == pytest.approx(1e-4, abs=1e-12)
    levels = quantised(saturated(read, -0.05, 1e-4), -0.05, 0.0501 / 4095)
    np.testing.assert_allclose(read, levels, atol=1e-12)


def test_noise_in_the_loop_depends_on_its_run_alone():
    runs = [LOOP.with_values(NOISY | {"measurement.seed": seed}) for seed in range(HALF_WIDTH + 2)]
    together, _ = measured(*runs)
    for k in (0, 2, HALF_WIDTH + 1):
        alone, _ = measured(runs[k])
        np.testing.assert_array_equal(alone.piston_position[0], together.piston_position[k])
    assert np.ptp(together.input_voltage[:, 100]) > 0.0


def test_solver_reads_the_same_as_the_kernel():
    run = LOOP.with_values(
        NOISY | {"control.proportional_gain": 50.0, "record.duration": 0.5, "input.period": 0.5}
    )
    sensors = Measurement([run])
    ours = simulate_batch([run], [2e-9], sensors)
    theirs = simulate_with_solver([run], [2e-9], "lsoda", tap=sensors)
    np.testing.assert_allclose(ours.piston_position, theirs.piston_position, atol=5e-6)
    assert np.mean(np.isclose(ours.input_voltage, theirs.input_voltage, rtol=0.0, atol=1e-9)) > 0.9
