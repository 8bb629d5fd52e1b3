import numpy as np
import pytest
import pywt
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import (
    coefficient_rms,
    detail_coefficients,
    detail_rms,
    level_bands,
    percentage_change,
)

RECORD = np.random.default_rng(7).normal(size=1024).cumsum()


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.sampled_from(["db8", "db2", "haar", "coif1"]))
def test_periodization_keeps_the_energy_of_the_record(seed, levels, name):
    record = np.random.default_rng(seed).normal(size=1024)
    rms = detail_rms(record, WaveletConfig(name=name, levels=levels, extension="periodization"))
    counts = 1024 / 2.0 ** np.arange(1, levels + 1)
    approximation = pywt.wavedec(record, name, mode="periodization", level=levels)[0]
    energy = np.sum(counts * rms**2) + np.sum(approximation**2)
    assert energy == pytest.approx(np.sum(record**2), rel=1e-10)


def test_a_polynomial_below_the_vanishing_moments_has_no_details_inside_the_record():
    wavelet = WaveletConfig(levels=1)
    ramp = np.linspace(-1.0, 1.0, 1024) ** 3
    _, details = detail_coefficients(ramp, wavelet, 1, np.arange(1024.0))
    assert np.abs(details[8:-8]).max() < 1e-10 < np.abs(details).max()


@pytest.mark.parametrize(("frequency", "level"), [(180.0, 1), (90.0, 2), (45.0, 3), (22.0, 4), (11.0, 5)])
def test_a_tone_shows_in_the_level_of_its_band(frequency, level):
    time = np.arange(5000) / 500.0
    rms = detail_rms(np.sin(2 * np.pi * frequency * time), WaveletConfig())
    low, high = level_bands(500.0, 5)[level - 1]
    assert low < frequency < high
    assert np.argmax(rms) == level - 1


def test_bands_halve_from_level_to_level():
    assert level_bands(500.0, 3) == [(125.0, 250.0), (62.5, 125.0), (31.25, 62.5)]


def test_delta_is_positive_where_the_rms_fell():
    np.testing.assert_allclose(percentage_change(np.array([4.0, 4.0]), np.array([3.0, 5.0])), [25.0, -25.0])


@given(st.floats(1e-3, 1e6), st.floats(1e-3, 1e6), st.floats(1e-3, 1e3))
def test_delta_does_not_depend_on_the_unit(healthy, faulty, factor):
    delta = percentage_change(np.array(healthy), np.array(faulty))
    assert percentage_change(np.array(factor * healthy), np.array(factor * faulty)) == pytest.approx(
        delta, rel=1e-9, abs=1e-9
    )


@pytest.mark.parametrize("extension", ["symmetric", "periodization", "smooth"])
@pytest.mark.parametrize("n_time", [1024, 1023])
def test_details_and_approximations_are_those_of_pywavelets(extension, n_time):
    wavelet = WaveletConfig(levels=5, extension=extension)
    records = np.stack([RECORD[:n_time], RECORD[::-1][:n_time]])
    rms = coefficient_rms(records, wavelet)
    details = pywt.wavedec(records, "db8", mode=extension, level=5)[1:]
    for level, detail in enumerate(reversed(details)):
        np.testing.assert_array_equal(rms.detail[:, level], np.sqrt(np.mean(detail**2, axis=-1)))
    for level in range(1, 6):
        approximation = pywt.wavedec(records, "db8", mode=extension, level=level)[0]
        expected = np.sqrt(np.mean(approximation**2, axis=-1))
        np.testing.assert_array_equal(rms.approximation[:, level - 1], expected)


def test_an_approximation_of_level_j_multiplies_a_constant_by_two_to_the_half_j():
    rms = coefficient_rms(np.full(1024, 8.6e6), WaveletConfig())
    np.testing.assert_allclose(rms.approximation, 8.6e6 * 2.0 ** (np.arange(1, 6) / 2.0), rtol=1e-9)
