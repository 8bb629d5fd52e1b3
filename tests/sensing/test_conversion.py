"""Laws of noise, drift, jitter, range and resolution."""

import numpy as np
import pytest

from hydrofdi.simulation import sensing
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.transforms import WaveletConfig, detail_rms
from tests import machines
from tests.machines import machine

SIGMA, MANY = 5e3, 2**17


def test_noise_is_white_and_gaussian_and_has_in_every_level_the_rms_that_its_gain_says():
    noise = sensing.gaussian_noise((SIGMA**2,), MANY, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(SIGMA, rel=4.0 / np.sqrt(2 * MANY))
    assert abs(np.mean(noise)) < 4.0 * SIGMA / np.sqrt(MANY)
    correlations = [np.mean(noise[lag:] * noise[:-lag]) / SIGMA**2 for lag in range(1, 33)]
    assert np.max(np.abs(correlations)) < 4.5 / np.sqrt(MANY)
    for sigmas, share in ((1, 0.3173), (2, 0.0455), (3, 0.0027)):
        assert np.mean(np.abs(noise) > sigmas * SIGMA) == pytest.approx(share, abs=4 * (share / MANY) ** 0.5)
    scatter = 5.0 / np.sqrt(2.0 * MANY / 2.0 ** np.arange(1, 6))
    ratio = detail_rms(noise, WaveletConfig(name="db8", levels=5)) / SIGMA
    assert np.all(np.abs(ratio - 1.0) < 2.0 * scatter)


@pytest.mark.parametrize("bits", [1, 12])
def test_quantised_signal_lies_on_the_levels_and_errs_by_white_noise(bits):
    lowest, highest = -2e5, 25e6
    resolution = (highest - lowest) / (2**bits - 1)
    signal = np.random.default_rng(2).uniform(lowest, highest, MANY)
    shown = sensing.quantised(signal, lowest, resolution)
    codes = (shown - lowest) / resolution
    np.testing.assert_allclose(codes, np.round(codes), atol=1e-9)
    assert codes.min() >= 0
    assert codes.max() <= 2**bits - 1 + 1e-9
    assert np.max(np.abs(shown - signal)) <= resolution / 2 * (1 + 1e-9)
    assert np.std(shown - signal) == pytest.approx(resolution / np.sqrt(12.0), rel=0.01)


def test_jitter_of_a_sine_is_its_slope_times_the_jitter_within_the_record():
    rate, jitter, amplitude, frequency = 500.0, 2e-5, 3e6, 20.0
    time = np.arange(100_000) / rate
    sine = amplitude * np.sin(2 * np.pi * frequency * time)
    instants = sensing.sampling_instants(time, jitter, np.random.default_rng(5))
    error = sensing.interpolated_signal(sine, time, instants) - sine
    expected = 2 * np.pi * frequency * amplitude * jitter / np.sqrt(2)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(expected, rel=0.02)
    assert time[0] <= instants.min() <= instants.max() <= time[-1]
    assert np.std(instants - time) == pytest.approx(jitter, rel=0.1)


STEP = np.concatenate([np.zeros(10), np.ones(390)])
"""Rises linearly over one step."""


def shown(signal, *lags):
    values = signal[:, None].copy()
    sensing.LagLanes([lags]).advance(values)
    return values[:, 0]


def lag_of(angle, zeta):
    return sensing.second_order_lag(angle, zeta) if zeta else sensing.first_order_lag(angle)


def _ramp(time, zeta, omega):
    """Response of a lag, of first order without a damping ratio, to max(t, 0)."""
    t = np.maximum(time, 0.0)
    if zeta is None:
        return t + np.expm1(-omega * t) / omega
    damped = omega * np.sqrt(1.0 - zeta**2)
    swing = 2 * zeta / omega * np.cos(damped * t) + (2 * zeta**2 - 1) / damped * np.sin(damped * t)
    return t - 2 * zeta / omega + np.exp(-zeta * omega * t) * swing


@pytest.mark.parametrize("zeta", [None, 0.1, 0.7])
def test_a_lag_answers_a_step_as_its_closed_form_and_decays_to_zero(zeta):
    angle, steps = 0.04 * np.pi, np.arange(-9.0, 391.0)  # 20 Hz at a step of 1 ms
    ramps = _ramp(steps, zeta, angle) - _ramp(steps - 1.0, zeta, angle)
    np.testing.assert_allclose(shown(STEP, lag_of(angle, zeta)), ramps, atol=1e-11)
    fallen = np.concatenate([np.ones(1), np.zeros(99_999)])
    assert shown(fallen, lag_of(0.1, zeta))[-1] == 0.0


@pytest.mark.parametrize("angle", [1e-6, 1e5])
def test_a_constant_is_shown_from_the_first_step_on_to_the_bit(angle):
    constant = np.full(500, 9.3e6)
    lags = sensing.first_order_lag(angle), sensing.second_order_lag(angle, 0.7)
    np.testing.assert_array_equal(shown(constant, *lags), constant)


def test_a_very_slow_lag_is_exact_after_many_steps():
    """0.01 Hz at a step of 0.1 ms, over two minutes."""
    ramp, omega = 1e-4 * np.arange(1_200_000), 0.02 * np.pi
    lagging = shown(ramp, sensing.first_order_lag(1e-4 * omega))
    np.testing.assert_allclose(lagging, _ramp(ramp, None, omega), atol=1e-7)


CONTROL = {"control.law": "p", "control.amplitude": 5e-3, "control.proportional_gain": 1.0}
RECORD = {"record.duration": 2.0, "input.period": 2.0, "friction.scale": 0.1}
LOOP = machine(CONTROL | RECORD, machines.LOOP)
IDEAL = machine(CONTROL | RECORD | {"control.feedback": "measured"}, {})
NOISY = {
    "position_sensor.noise": 20e-6, "position_sensor.bias": 1e-4, "position_sensor.drift": 1e-5,
    "position_sensor.gain_error": 0.01, "position_sensor.hum": 50e-6,
    "position_sensor.lowest": -0.05, "position_sensor.highest": 0.05, "position_sensor.bits": 12,
}  # fmt: skip


def measured(*runs):
    """What happened, and what the sensors show."""
    sensors = sensing.Measurement(runs)
    truth = simulate_batch(runs, [2e-9] * len(runs), sensors)
    return truth, sensors.show(truth)


@pytest.mark.parametrize(
    ("run", "tolerance"), [(LOOP, 1e-6), pytest.param(IDEAL, 0.0, marks=pytest.mark.long)]
)
def test_ideal_sensor_in_the_loop_changes_nothing(run, tolerance):
    ideal = IDEAL.with_values({"control.feedback": "ideal"})
    read, true = simulate_batch([run, ideal], [2e-9] * 2).input_voltage
    np.testing.assert_allclose(read, true, rtol=0.0, atol=tolerance)


def test_bias_of_the_reading_shifts_the_true_position():
    values = {
        "control.law": "pi", "control.proportional_gain": 100.0, "control.integral_gain": 400.0,
        "actuator.load_stiffness": 0.0, "record.duration": 6.0, "input.period": 12.0,
    }  # fmt: skip
    runs = [LOOP.with_values(values | {"position_sensor.bias": bias}) for bias in (0.0, 1e-3)]
    truth, shown = measured(*runs)
    np.testing.assert_allclose(np.diff(truth.piston_position[:, -250:], axis=0), -1e-3, rtol=0.02)
    np.testing.assert_allclose(shown.piston_position[1, -250:], 5e-3, rtol=0.02)


@pytest.mark.parametrize(
    ("sample_time", "pairing", "highest"),
    [(2e-3, "common", 0.05), (4e-3, "independent", 1e-4), (1e-3, "independent", 0.05)],
)
def test_controller_reads_what_the_record_shows_at_the_same_instants(sample_time, pairing, highest):
    """A law without memory tells what it read: u = K_p (r − x), with K_p = 1 V/m."""
    values = NOISY | {"control.sample_time": sample_time, "measurement.pairing": pairing}
    values["position_sensor.highest"] = highest
    truth, shown = measured(LOOP.with_values(values))
    every = max(1, round(sample_time * LOOP.record.sampling_frequency))
    read = (truth.reference_position - truth.input_voltage)[0, ::every]
    np.testing.assert_allclose(read, shown.piston_position[0, ::every], atol=1e-12)
    assert np.std(read - truth.piston_position[0, ::every]) > 10e-6
    assert read.max() <= highest * (1.0 + 1e-9)


def test_noise_between_the_samples_is_as_strong_and_its_own_and_density_that_of_the_rate_of_the_controller():
    fast = {"control.sample_time": 0.2e-3}
    noise = sensing.feedback_noise(LOOP.with_values(NOISY | {"position_sensor.hum": 0.0} | fast))
    assert noise.size == 10_000
    assert np.std(noise) == pytest.approx(20e-6, rel=0.05)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.05
    dense = {"position_sensor.noise_density": 1e-6, "measurement.anti_alias": 50.0}
    noise = sensing.feedback_noise(LOOP.with_values(dense | fast))
    assert np.std(noise) == pytest.approx(1e-6 * np.sqrt(0.5 / 0.2e-3), rel=0.05)


def test_gain_error_is_relative_and_hum_a_sine_of_the_mains_with_a_phase_of_its_own():
    values = {
        "pressure_1_sensor.gain_error": 0.005, "pressure_2_sensor.hum": 25e3, "supply_sensor.hum": 25e3,
        "supply_sensor.hum_frequency": 60.0,
    }  # fmt: skip
    truth, shown = measured(LOOP.with_values(values), LOOP.with_values(values | {"measurement.seed": 1}))
    np.testing.assert_allclose(shown.chamber_1_pressure, 1.005 * truth.chamber_1_pressure, rtol=1e-15)
    phases = set()
    for signal, frequency in (("chamber_2_pressure", 50.0), ("valve_supply_pressure", 60.0)):
        for hum in getattr(shown, signal) - getattr(truth, signal):
            turning = np.exp(-2j * np.pi * frequency * truth.time)
            part = 2.0 * np.mean(hum * turning)  # both frequencies have whole periods in the record
            np.testing.assert_allclose(hum, np.real(part * np.conj(turning)), atol=1e-3)
            assert abs(part) == pytest.approx(25e3, rel=1e-9)
            phases.add(round(float(np.angle(part)), 6))
    assert len(phases) == 4
