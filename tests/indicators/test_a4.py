import numpy as np
import pywt

from indicators.signals import P1, P2, batch, measured, noise

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
