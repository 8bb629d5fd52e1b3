"""Laws of the undecimated transform: it holds all start phases of the decimated one."""

import numpy as np
import pytest
import pywt
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.indicators.catalogue.dwt import phase_rms
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.undecimated import (
    boundary_length,
    phase_detail_rms,
    undecimated_coefficients,
    undecimated_rms,
)
from hydrofdi.transforms.wavelet import detail_rms

ORTHOGONAL = st.sampled_from(["db8", "db2", "haar", "coif1", "sym4"])


def _record(seed: int, n_time: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=n_time).cumsum()


@given(st.integers(0, 2**32 - 1), st.integers(40, 700), st.integers(1, 5), ORTHOGONAL)
def test_energy_is_partitioned_at_any_length(seed, n_time, levels, name):
    record = _record(seed, n_time)
    rms = undecimated_rms(record, WaveletConfig(name=name, levels=levels))
    power = np.square(rms.detail) / 2.0 ** np.arange(1, levels + 1)
    total = power.sum() + rms.approximation[-1] ** 2 / 2.0**levels
    assert total == pytest.approx(np.mean(record**2), rel=1e-10)


@given(st.integers(0, 2**32 - 1), st.integers(64, 700), st.integers(0, 700))
def test_the_rms_does_not_depend_on_where_a_circle_starts(seed, n_time, shift):
    record = _record(seed, n_time)
    wavelet = WaveletConfig(levels=4)
    turned = undecimated_rms(np.roll(record, shift), wavelet)
    np.testing.assert_allclose(turned.detail, undecimated_rms(record, wavelet).detail, rtol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(64, 700), st.integers(1, 5))
def test_parseval_gives_the_rms_of_the_coefficients(seed, n_time, levels):
    record, wavelet = _record(seed, n_time), WaveletConfig(levels=levels)
    details, approximations = undecimated_coefficients(record, wavelet)
    rms = undecimated_rms(record, wavelet)
    np.testing.assert_allclose(np.sqrt(np.mean(details**2, axis=-1)), rms.detail, rtol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.mean(approximations**2, axis=-1)), rms.approximation, rtol=1e-9)


def test_the_bits_of_a_record_do_not_depend_on_the_others():
    records = np.random.default_rng(3).normal(size=(67, 4000))
    together = undecimated_rms(records, WaveletConfig())
    for first, last in ((0, 1), (5, 12), (40, 67)):
        alone = undecimated_rms(records[first:last], WaveletConfig())
        np.testing.assert_array_equal(alone.detail, together.detail[first:last])
        np.testing.assert_array_equal(alone.approximation, together.approximation[first:last])


@pytest.mark.parametrize("name", ["db8", "haar", "bior2.4"])
def test_the_coefficients_are_those_of_the_stationary_transform_of_pywavelets(name):
    record, levels = _record(3, 1024), 5
    details, approximations = undecimated_coefficients(record, WaveletConfig(name=name, levels=levels))
    for level, (approximation, detail) in enumerate(reversed(pywt.swt(record, name, level=levels))):
        # PyWavelets centres each filter; the coefficients are the same, turned by half of its length.
        delay = pywt.Wavelet(name).dec_len // 2 * (2 ** (level + 1) - 1)
        np.testing.assert_allclose(np.roll(details[level], -delay), detail, atol=1e-9)
        np.testing.assert_allclose(np.roll(approximations[level], -delay), approximation, atol=1e-9)


@pytest.mark.parametrize("phase", [0, 1, 5, 31])
@pytest.mark.parametrize("name", ["db8", "sym4"])
def test_a_decimated_transform_keeps_every_second_to_the_j_coefficient_from_its_phase(name, phase):
    record, wavelet = _record(4, 4000), WaveletConfig(name=name)
    details, _ = undecimated_coefficients(record, wavelet)
    decimated = pywt.wavedec(record[phase:], name, mode="zero", level=5)[:0:-1]
    for level in range(5):
        distance, first = 2 ** (level + 1), 20  # the first coefficients depend on the extension
        instants = phase + distance * (np.arange(first, 60) + 1) - 1
        np.testing.assert_allclose(details[level][instants], decimated[level][first:60], atol=1e-9)


def test_the_mean_square_is_the_mean_over_the_start_phases():
    record, wavelet = _record(5, 32 * 40), WaveletConfig()
    details, _ = undecimated_coefficients(record, wavelet)
    phases = phase_detail_rms(details, first_sample=0)
    assert phases.shape == (32, 5)
    expected = undecimated_rms(record, wavelet).detail
    np.testing.assert_allclose(np.sqrt(np.mean(phases**2, axis=0)), expected, rtol=1e-10)


@given(st.integers(0, 100), st.integers(0, 31))
def test_phases_count_from_the_start_of_the_record(first_sample, phase):
    record, wavelet = _record(6, 640), WaveletConfig()
    details, _ = undecimated_coefficients(record, wavelet)
    here = phase_detail_rms(details, first_sample)[phase]
    there = phase_detail_rms(details, 0)[(phase - first_sample) % 32]
    np.testing.assert_array_equal(here, there)


def test_phases_of_the_middle_of_a_record_are_those_of_the_decimated_transform():
    record, wavelet = _record(7, 64_000), WaveletConfig(boundary="left_out")
    details, _ = undecimated_coefficients(record, wavelet)
    outside = boundary_length(wavelet)
    ours = phase_detail_rms(details[:, outside:], outside)
    theirs = phase_rms(record, wavelet)
    np.testing.assert_allclose(ours, theirs, rtol=0.03)  # windows differ by one boundary


@pytest.mark.parametrize("extension", ["symmetric", "zero", "smooth"])
def test_without_boundary_coefficients_the_extension_has_no_effect(extension):
    record = _record(9, 3000)
    symmetric = detail_rms(record, WaveletConfig(boundary="left_out"))
    other = detail_rms(record, WaveletConfig(boundary="left_out", extension=extension))
    np.testing.assert_array_equal(symmetric, other)
    assert not np.allclose(symmetric, detail_rms(record, WaveletConfig()), rtol=1e-6)
