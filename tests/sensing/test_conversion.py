"""Laws of noise, drift, jitter, range and resolution."""

import numpy as np
import pytest

from hydrofdi.sensing import quantisation_noise
from hydrofdi.sensing.measurement import quantised
from hydrofdi.sensing.noise import gaussian_noise
from hydrofdi.sensing.sampling import interpolated_signal, sampling_instants
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
