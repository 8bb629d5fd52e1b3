"""Laws of noise, drift, jitter, range and resolution."""

import numpy as np
import pytest

from hydrofdi.sensing import quantisation_noise
from hydrofdi.sensing.measurement import quantised
from hydrofdi.sensing.noise import gaussian_noise
from hydrofdi.sensing.sampling import (
    LagLanes,
    first_order_lag,
    interpolated_signal,
    sampling_instants,
    second_order_lag,
)
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import detail_rms, noise_rms

SIGMA, MANY = 5e3, 2**17


@pytest.fixture(scope="module")
def noise():
    return gaussian_noise((SIGMA**2,), MANY, np.random.default_rng(1))


def test_noise_has_its_standard_deviation_and_no_mean(noise):
    assert np.std(noise) == pytest.approx(SIGMA, rel=4.0 / np.sqrt(2 * MANY))
    assert abs(np.mean(noise)) < 4.0 * SIGMA / np.sqrt(MANY)


def test_noise_is_white(noise):
    correlations = [np.mean(noise[lag:] * noise[:-lag]) / SIGMA**2 for lag in range(1, 33)]
    assert np.max(np.abs(correlations)) < 4.5 / np.sqrt(MANY)


def test_noise_is_gaussian(noise):
    for sigmas, share in ((1, 0.3173), (2, 0.0455), (3, 0.0027)):
        assert np.mean(np.abs(noise) > sigmas * SIGMA) == pytest.approx(share, abs=4 * (share / MANY) ** 0.5)


@pytest.mark.parametrize("name", ["db8", "sym4", "bior3.3"])
def test_noise_has_in_every_level_the_rms_that_its_gain_says(noise, name):
    wavelet = WaveletConfig(name=name, levels=5)
    expected = noise_rms(wavelet, (SIGMA**2,))
    scatter = 5.0 / np.sqrt(2.0 * MANY / 2.0 ** np.arange(1, 6))
    assert np.all(np.abs(detail_rms(noise, wavelet) / expected - 1.0) < 2.0 * scatter)


@pytest.mark.parametrize("bits", [1, 8, 12])
def test_quantised_signal_lies_on_the_levels_within_half_a_level(bits):
    lowest, highest = -2e5, 25e6
    resolution = (highest - lowest) / (2**bits - 1)
    signal = np.random.default_rng(2).uniform(lowest, highest, 20_000)
    shown = quantised(signal, lowest, resolution)
    codes = (shown - lowest) / resolution
    np.testing.assert_allclose(codes, np.round(codes), atol=1e-9)
    assert codes.min() >= 0
    assert codes.max() <= 2**bits - 1 + 1e-9
    assert np.max(np.abs(shown - signal)) <= resolution / 2 * (1 + 1e-9)


def test_quantisation_error_is_the_white_noise_that_is_stated():
    signal = np.random.default_rng(2).uniform(0.0, 25e6, MANY)
    resolution = 25e6 / 4095
    error = quantised(signal, 0.0, resolution) - signal
    assert np.std(error) == pytest.approx(quantisation_noise(resolution), rel=0.01)


@pytest.mark.parametrize("frequency", [5.0, 20.0])
def test_jitter_of_a_sine_is_its_slope_times_the_jitter(frequency):
    rate, jitter, amplitude = 500.0, 2e-5, 3e6
    time = np.arange(100_000) / rate
    sine = amplitude * np.sin(2 * np.pi * frequency * time)
    instants = sampling_instants(time, jitter, np.random.default_rng(5))
    error = interpolated_signal(sine, time, instants) - sine
    expected = 2 * np.pi * frequency * amplitude * jitter / np.sqrt(2)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(expected, rel=0.02)


def test_sampling_stays_within_the_record():
    time = np.arange(1000) / 500.0
    instants = sampling_instants(time, 5e-4, np.random.default_rng(5))
    assert instants.min() >= time[0]
    assert instants.max() <= time[-1]
    assert np.std(instants - time) == pytest.approx(5e-4, rel=0.1)


INTERVAL, CORNER = 1e-3, 20.0
OMEGA = 2.0 * np.pi * CORNER
ANGLE = OMEGA * INTERVAL
TIME = INTERVAL * np.arange(400)
STEP = np.concatenate([np.zeros(10), np.ones(390)])
"""Rises linearly over one step."""


def shown(signal, *lags):
    values = signal[:, None].copy()
    LagLanes([lags]).advance(values)
    return values[:, 0]


def _first_ramp(time):
    """Response of the first-order lag to max(t, 0)."""
    t = np.maximum(time, 0.0)
    return t - (1.0 - np.exp(-OMEGA * t)) / OMEGA


def _second_ramp(time, zeta):
    """Response of the underdamped second-order lag to max(t, 0)."""
    t, damped = np.maximum(time, 0.0), OMEGA * np.sqrt(1.0 - zeta**2)
    swing = 2 * zeta / OMEGA * np.cos(damped * t) + (2 * zeta**2 - 1) / damped * np.sin(damped * t)
    return t - 2 * zeta / OMEGA + np.exp(-zeta * OMEGA * t) * swing


def test_first_order_lag_answers_a_step_as_its_closed_form():
    ramps = _first_ramp(TIME - TIME[9]) - _first_ramp(TIME - TIME[10])
    np.testing.assert_allclose(shown(STEP, first_order_lag(ANGLE)), ramps / INTERVAL, atol=1e-11)


@pytest.mark.parametrize("zeta", [0.1, 0.7])
def test_second_order_lag_answers_a_step_as_its_closed_form(zeta):
    ramps = _second_ramp(TIME - TIME[9], zeta) - _second_ramp(TIME - TIME[10], zeta)
    np.testing.assert_allclose(shown(STEP, second_order_lag(ANGLE, zeta)), ramps / INTERVAL, atol=1e-11)


@pytest.mark.parametrize("angle", [1e-6, 1.0, 1e5])
def test_a_constant_is_shown_from_the_first_step_on_to_the_bit(angle):
    constant = np.full(500, 9.3e6)
    lags = first_order_lag(angle), second_order_lag(angle, 0.7)
    np.testing.assert_array_equal(shown(constant, *lags), constant)


def test_a_very_slow_lag_is_exact_after_many_steps():
    """0.01 Hz at a step of 0.1 ms, over two minutes: the ramp's closed form."""
    omega, steps = 2.0 * np.pi * 0.01, np.arange(1_200_000)
    ramp = 1e-4 * steps
    lagging = ramp - 1.0 / omega * -np.expm1(-omega * ramp)
    np.testing.assert_allclose(shown(ramp, first_order_lag(1e-4 * omega)), lagging, atol=1e-7)


def test_an_error_decays_to_zero_and_not_to_subnormal_numbers():
    fallen = np.concatenate([np.ones(1), np.zeros(99_999)])
    assert shown(fallen, first_order_lag(0.01))[-1] == 0.0
    assert shown(fallen, second_order_lag(0.01, 0.7))[-1] == 0.0


LANES = [
    (),
    (first_order_lag(0.05),),
    (second_order_lag(0.1, 0.7), second_order_lag(0.2, 0.4)),
] * 11  # fmt: skip


@pytest.mark.parametrize("cuts", [[], [1], [7, 8, 399], list(range(1, 400))])
def test_bits_depend_neither_on_stretches_nor_on_neighbours(cuts):
    signals = np.random.default_rng(4).normal(size=(400, len(LANES)))
    cut, together = signals.copy(), LagLanes(LANES)
    for stretch in np.split(cut, cuts):
        together.advance(stretch)
    for lane, lags in enumerate(LANES):
        np.testing.assert_array_equal(cut[:, lane], shown(signals[:, lane], *lags))
    np.testing.assert_array_equal(cut[:, 0], signals[:, 0])
