import numpy as np
import pytest
from scipy.signal import ShortTimeFFT, get_window

from hydrofdi.transforms.spectrum import short_time_spectra
from indicators.laws import (
    SAMPLING_FREQUENCY,
    noise,
    values,
)


def tone(frequency, n_time=4000):
    return 8e6 + 2e5 * np.sin(2 * np.pi * frequency * np.arange(n_time) / SAMPLING_FREQUENCY + 0.3)


@pytest.mark.parametrize(("n_segment", "hop"), [(125, 31), (128, 64)])
def test_spectra_are_those_of_scipy(n_segment, hop):
    record = noise(1, 2000)
    window = get_window("hann", n_segment)
    library = ShortTimeFFT(window, hop, SAMPLING_FREQUENCY, scale_to="magnitude")
    ours = short_time_spectra(record, n_segment, hop)
    theirs = library.stft_detrend(record, "constant", 0, len(ours), k_offset=library.m_num_mid)
    np.testing.assert_allclose(np.abs(ours), 2 * np.abs(theirs.T), rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("frequency", [40.0, 58.0, 68.7, 70.1, 111.3])
def test_a_tone_is_found_between_the_lines_of_the_spectrum(frequency):
    found = values("stft", tone(frequency))
    assert found["frequency"] == pytest.approx(frequency, abs=0.02)
    assert found["amplitude"] == pytest.approx(2e5, rel=0.005)
    assert found["frequency_spread"] < 0.1
    assert found["amplitude_spread"] < 2e3


def test_a_frequency_that_rises_has_its_mean_and_its_spread():
    time = np.arange(8000) / SAMPLING_FREQUENCY
    found = values("stft", 1e5 * np.sin(2 * np.pi * (50.0 + 1.25 * time) * time))
    assert found["frequency"] == pytest.approx(70.0, abs=0.3)
    assert found["frequency_spread"] == pytest.approx(40.0 / np.sqrt(12), rel=0.05)


def test_only_the_band_is_looked_at():
    loud, quiet = tone(100.0), 0.1 * tone(60.0)
    assert values("stft", loud + quiet)["frequency"] == pytest.approx(100.0, abs=0.5)
    assert values("stft", loud + quiet, band=["40 Hz", "80 Hz"])["frequency"] == pytest.approx(60.0, abs=0.5)
