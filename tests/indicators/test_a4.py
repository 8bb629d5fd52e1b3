import numpy as np
import pywt

from indicators.laws import noise
from indicators.signals import P1, P2, assert_rows_stand_alone, batch, measured

N = 3000


def test_the_numbers_are_those_of_pywavelets():
    first, second = noise(1, N), noise(2, N, mean=5e6)
    values, _ = measured(batch({P1: first, P2: second}), "a4")
    for name, record in (("chamber_1", first), ("chamber_2", second)):
        approximation = pywt.wavedec(record, "db8", level=4)[0]
        np.testing.assert_allclose(values[name], np.sqrt(np.mean(approximation**2)), rtol=1e-12)


def test_a_constant_pressure_gives_four_times_itself_and_white_noise_its_deviation():
    values, _ = measured(batch({P1: np.full(N, 8e6), P2: noise(3, N, mean=0.0)}), "a4", boundary="left_out")
    np.testing.assert_allclose(values["chamber_1"], 4.0 * 8e6, rtol=1e-12)
    np.testing.assert_allclose(values["chamber_2"], 1e5, rtol=0.2)


def test_another_level_is_another_approximation():
    record = noise(4, N)
    values, _ = measured(batch({P1: record, P2: record}), "a4", level=2, wavelet="haar")
    approximation = pywt.wavedec(record, "haar", level=2)[0]
    np.testing.assert_allclose(values["chamber_1"], np.sqrt(np.mean(approximation**2)), rtol=1e-12)


def test_a_record_that_is_too_short_is_refused():
    assert "too few for level 4 of db8" in measured(batch({P1: np.ones(200), P2: np.ones(200)}), "a4")[1][0]


def test_one_chamber_is_not_enough():
    assert measured(batch({P1: np.ones(N)}), "a4")[1] == ("has no chamber_2_pressure",)


def test_another_unit_scales_the_numbers():
    channels = {P1: noise(5, N), P2: noise(6, N)}
    values, _ = measured(batch(channels), "a4")
    other, _ = measured(batch({channel: 4.0 * channels[channel] for channel in channels}), "a4")
    np.testing.assert_array_equal(other["chamber_1"], 4.0 * values["chamber_1"])


def test_a_record_stands_alone():
    assert_rows_stand_alone(batch({P1: noise(7, (3, N)), P2: noise(8, (3, N))}), "a4")
