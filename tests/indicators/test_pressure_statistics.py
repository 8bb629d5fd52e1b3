import numpy as np
import pytest
from scipy import stats

from indicators.signals import P1, batch, measured, noise, square_wave


def test_the_numbers_are_those_of_scipy():
    record = noise(1, 4000) + 1e6 * np.sin(np.arange(4000) / 30)
    values, _ = measured(batch({P1: record}), "pressure_statistics")
    np.testing.assert_allclose(values["mean"], record.mean(), rtol=1e-13)
    np.testing.assert_allclose(values["standard_deviation"], record.std(), rtol=1e-10)
    np.testing.assert_allclose(values["increments"], np.diff(record).std(), rtol=1e-10)
    np.testing.assert_allclose(values["kurtosis"], stats.kurtosis(record, fisher=False), rtol=1e-10)
    np.testing.assert_allclose(values["peak_to_peak"], np.ptp(record), rtol=1e-13)


def test_a_square_wave_a_sine_and_noise_have_the_kurtosis_and_crest_that_they_have():
    phase = 2 * np.pi * np.arange(20_000) / 20_000
    waves = np.stack([square_wave(20_000, 100), np.sin(7 * phase), noise(2, 20_000, size=1.0, mean=0.0)])
    values, _ = measured(batch({P1: 1e5 + waves}), "pressure_statistics")
    np.testing.assert_allclose(values["kurtosis"][:2], [1.0, 1.5], rtol=1e-6)
    np.testing.assert_allclose(values["crest_factor"][:2], [1.0, np.sqrt(2.0)], rtol=1e-6)
    np.testing.assert_allclose(values["kurtosis"][2], 3.0, atol=0.15)
    np.testing.assert_allclose(values["increments"][2], np.sqrt(2.0), rtol=0.03)


@pytest.mark.parametrize("level", [0.0, 8.1e6, 0.1])
def test_what_does_not_move_has_no_kurtosis(level):
    values, obstacles = measured(batch({P1: np.full(3000, level)}), "pressure_statistics")
    assert values["mean"] == level
    assert values["standard_deviation"] == 0.0
    assert np.isnan(values["kurtosis"]).all()
    assert obstacles == (None,)
