"""Noise by density: what the anti-alias filter and sampling make of it."""

import numpy as np
import pytest
from scipy import integrate

from hydrofdi.config import RunSpec, load_experiment
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.simulation.sensing import filtered_noise_autocovariance, gaussian_noise, noise_autocovariance

DENSITY, CORNER = 20.0, 100.0


def run_with(*settings):
    return load_experiment(None, settings).nominal_parameters


def autocovariance_of(*settings):
    run = run_with(*settings)
    return noise_autocovariance(run.pressure_1_sensor, run.measurement, run.record)


@pytest.mark.parametrize(("order", "delay"), [(2, 0.0), (2, 1e-3), (4, 0.0), (4, 2e-2)])
def test_autocovariance_is_the_transform_of_what_the_filter_lets_through(order, delay):
    def spectrum(frequency):
        return float(DENSITY**2 / (1.0 + (frequency / CORNER) ** (2 * order)))

    more = {"weight": "cos", "wvar": 2.0 * np.pi * delay} if delay else {}
    expected, _ = integrate.quad(spectrum, 0.0, 200 * CORNER, limit=2000, **more)
    found = filtered_noise_autocovariance(DENSITY, CORNER, order, delay)
    assert found == pytest.approx(expected, abs=1e-5 * DENSITY**2 * CORNER)


def test_noise_is_stationary_from_the_first_sample_on():
    autocovariance = autocovariance_of("pressure_1_sensor.noise_density=20", "measurement.anti_alias=20 Hz")
    first = np.array(
        [gaussian_noise(autocovariance, 50, np.random.default_rng(k))[[0, -1]] for k in range(4000)]
    )
    np.testing.assert_allclose(np.var(first, axis=0), autocovariance[0], rtol=4.0 * np.sqrt(2.0 / 4000))
    correlation = np.mean(first[:, 0] * first[:, 1]) / autocovariance[0]
    assert abs(correlation) < 4.0 / np.sqrt(4000)


def test_spread_over_repeats_covers_the_stated_variance():
    """In the record of 100 seeds, the 95 % interval of the variance holds the theory about 95 times."""
    settings = ("record.duration=2 s", "input.amplitude=0", "supply_sensor.noise_density=20 Pa/√Hz")
    runs = [run_with(*settings, f"measurement={{seed: {seed}, anti_alias: 100 Hz}}") for seed in range(100)]
    noise = (
        compute_columns([Job.of(RunSpec(run), "run", 0.0) for run in runs])["valve_supply_pressure"] - 17.2e6
    )
    autocovariance = np.zeros(1000)
    known = noise_autocovariance(runs[0].supply_sensor, runs[0].measurement, runs[0].record)
    autocovariance[: len(known)] = known
    spread = np.sqrt(2.0 * (2.0 * np.sum(autocovariance**2) - autocovariance[0] ** 2) / 1000)
    covered = np.abs(np.mean(noise**2, axis=1) - autocovariance[0]) < 1.96 * spread
    assert 87 <= covered.sum() <= 100
    assert known[0] == pytest.approx(20.0**2 * 100.0 * (np.pi / 8) / np.sin(np.pi / 8))


@pytest.mark.parametrize(("settings", "variance"), [
    (["noise=3 Pa"], 9.0), (["noise_density=2 Pa/√Hz"], 4.0 * 250.0),
    (["noise=3 Pa", "noise_bandwidth=100 Hz"], 9.0 / 100.0 * 250.0),
    (["noise=3 Pa", "noise_bandwidth=10 kHz"], 9.0), ([], 0.0),
])  # fmt: skip
def test_without_a_filter_noise_is_white_with_the_stated_variance(settings, variance):
    found = autocovariance_of(*(f"pressure_1_sensor.{setting}" for setting in settings))
    assert found == (pytest.approx(variance),)


def test_filter_leaves_noise_of_a_sample_and_takes_that_of_a_bandwidth_as_its_density():
    shared = "measurement={anti_alias: 100 Hz, anti_alias_order: 2}"
    assert autocovariance_of("pressure_1_sensor.noise=3 Pa", shared) == (9.0,)
    stated = "pressure_1_sensor={noise: 200 Pa, noise_bandwidth: 10 kHz}"
    np.testing.assert_allclose(
        autocovariance_of(stated, shared),
        autocovariance_of("pressure_1_sensor.noise_density=2 Pa/√Hz", shared),
    )
