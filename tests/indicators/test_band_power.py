import numpy as np
import pytest
from scipy.signal import welch

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from indicators.signals import SAMPLING_FREQUENCY, noise, ringing, values


@pytest.mark.parametrize("segment", [1.0, 0.502, 0.514])
def test_bands_without_a_gap_share_the_power_of_the_spectrum(segment):
    record = ringing(1, 1)
    frequency, density = welch(record[0], SAMPLING_FREQUENCY, "hann", round(segment * SAMPLING_FREQUENCY))
    total = np.sum(density) * frequency[1]
    default = values("band_power", record, segment=segment)
    bands = [[0, 3.3], [3.3, "41 Hz"], ["41 Hz", 41.2], [41.2, 250]]
    given = values("band_power", record, segment=segment, bands=bands)
    for found in (default, given):
        np.testing.assert_allclose(sum(rms**2 for rms in found.values()), total, rtol=1e-12)


def test_a_band_that_ends_between_two_lines_has_its_share_of_them():
    record = ringing(2, 1)
    frequency, density = welch(record[0], SAMPLING_FREQUENCY, "hann", 500)
    assert frequency[1] == 1.0
    found = values("band_power", record, bands=[[40.25, 42.5]])
    exact = 0.25 * density[40] + density[41] + density[42]
    np.testing.assert_allclose(found["b1"] ** 2, exact, rtol=1e-12)


def test_a_tone_has_its_rms_in_its_octave():
    time = np.arange(5000) / SAMPLING_FREQUENCY
    found = values("band_power", 8e6 + 3e5 * np.sin(2 * np.pi * 90.0 * time))
    assert found["b2"] == pytest.approx(3e5 / np.sqrt(2), rel=1e-9)
    assert all(found[name] < 1.0 for name in ("b1", "b3", "b4", "b5", "b6"))


def test_white_noise_has_the_share_of_the_width_of_a_band():
    found = values("band_power", noise(3, (8, 20_000), size=4.0, mean=0.0))
    for octave in range(1, 6):
        rms = np.sqrt(np.mean(found[f"b{octave}"] ** 2))
        assert rms == pytest.approx(4.0 * 2 ** (-octave / 2), rel=0.04)


def test_a_band_that_falls_is_a_mistake():
    with pytest.raises(
        ConfigError, match=r"a band must be \[lowest, highest\] frequency; found \[90.0, 40.0\] Hz"
    ):
        make_indicators({"band_power": {"bands": [[90, 40]]}})
