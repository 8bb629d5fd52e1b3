import numpy as np
import pytest

from hydrofdi.indicators.catalogue.vmd import variational_modes
from indicators.laws import (
    SAMPLING_FREQUENCY,
    ringing,
    values,
)


def tones(n_time=3000):
    time = np.arange(n_time) / SAMPLING_FREQUENCY
    parts = {10.0: 8e5, 70.0: 2e5, 150.0: 4e5}
    return 8e6 + sum(size * np.cos(2 * np.pi * frequency * time) for frequency, size in parts.items())


@pytest.mark.parametrize("n_time", [3000, 3001])
def test_tones_are_found_with_their_frequency_and_size(n_time):
    found = values("vmd", tones(n_time), modes=3)
    for mode, (frequency, size) in enumerate([(10.0, 8e5), (70.0, 2e5), (150.0, 4e5)], 1):
        assert found[f"frequency{mode}"] == pytest.approx(frequency, abs=0.5)
        assert found[f"rms{mode}"] == pytest.approx(size / np.sqrt(2), rel=0.02)
    assert found["iterations"] < 1000


def test_one_mode_without_a_weight_is_the_record_less_its_mean():
    record = ringing(1, 1)
    found = values("vmd", record, modes=1, bandwidth_weight=1e-12)
    np.testing.assert_allclose(found["rms1"], record.std(), rtol=1e-9)


def test_modes_are_where_no_change_of_them_lowers_the_cost():
    record = ringing(2, 1, 600)[0]
    spectrum_weight, frequency = 2000.0, np.arange(600) / 1200.0
    from scipy.fft import dct

    spectrum = dct(record - record.mean(), norm="ortho")
    found = variational_modes(record, 2, spectrum_weight, 1e-16, 10_000)
    gains = 1.0 / (spectrum_weight * np.square(frequency - found.frequency[:, None]))
    others = spectrum / (1.0 + gains.sum(axis=0))  # what the modes leave of the spectrum at the optimum
    modes = np.where(np.isfinite(gains), gains, 0.0) * others
    np.testing.assert_allclose(np.sqrt(np.mean(modes**2, axis=1)), found.rms, rtol=1e-3)


def test_modes_are_those_of_vmdpy():
    library = pytest.importorskip("vmdpy")
    record = ringing(7, 1, 1000)[0] / 1e6
    modes, _, centres = library.VMD(record - record.mean(), 2000.0, 0.0, 3, 0, 1, 1e-14)
    found = variational_modes(record, 3, 2000.0, 1e-12, 500)
    order = np.argsort(centres[-1])
    np.testing.assert_allclose(centres[-1][order], found.frequency, rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(np.sqrt(np.mean(modes[order] ** 2, axis=1)), found.rms, rtol=1e-2)
