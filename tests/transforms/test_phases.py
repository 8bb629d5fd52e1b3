"""The details at every start phase are, to the bit, those of the record from each sample on."""

import numpy as np
import pytest
import pywt

from hydrofdi.indicators.catalogue.dwt import phase_rms
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.wavelet import detail_rms, n_phase


def assert_exact(n_time, wavelet):
    records = 8e6 + 1e5 * np.cumsum(np.random.default_rng(n_time).normal(size=(2, n_time)), axis=1)
    found = phase_rms(records, wavelet)
    assert found.shape == (2, n_phase(wavelet.levels), wavelet.levels)
    for phase in range(n_phase(wavelet.levels)):
        np.testing.assert_array_equal(found[:, phase], detail_rms(records[:, phase:], wavelet))


@pytest.mark.parametrize("extension", pywt.Modes.modes)
def test_with_each_extension(extension):
    assert_exact(4501, WaveletConfig(extension=extension))


@pytest.mark.parametrize("extension", ["symmetric", "smooth", "periodic"])
def test_without_the_boundary(extension):
    assert_exact(4501, WaveletConfig(extension=extension, boundary="left_out"))


@pytest.mark.parametrize("name", ["haar", "db2", "sym5", "db20", "bior3.1", "dmey"])
def test_with_each_length_of_filter(name):
    assert_exact(9000, WaveletConfig(name=name, levels=4))


@pytest.mark.parametrize("levels", [1, 2, 6])
def test_with_any_number_of_levels(levels):
    assert_exact(9000, WaveletConfig(levels=levels))


@pytest.mark.parametrize("n_time", [500, 3839, 3840, 3841, 3871, 4001])
def test_of_short_and_odd_records(n_time):
    assert_exact(n_time, WaveletConfig())
