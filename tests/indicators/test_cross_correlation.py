import numpy as np
import pytest

from indicators.laws import noise
from indicators.signals import P1, P2, batch, measured

N = 3000


def test_the_lag_of_a_delayed_pressure_is_its_delay():
    white = noise(1, N + 100, mean=0.0)
    for delay in (-37, 0, 5, 50):
        first, second = 8e6 + white[50 : 50 + N], 8e6 - white[50 - delay : 50 - delay + N]
        values, _ = measured(batch({P1: first, P2: second}), "cross_correlation")
        np.testing.assert_allclose(values["lag"], delay / 500.0)
        np.testing.assert_allclose(values["peak_coefficient"], -1.0, atol=0.03)
        np.testing.assert_allclose(values["peak"], -1e5, rtol=0.03)


def test_the_numbers_are_those_of_numpy():
    first, second = noise(2, N), noise(3, N)
    second = second + 0.5 * np.roll(first, 20)
    values, _ = measured(batch({P1: first, P2: second}), "cross_correlation")
    np.testing.assert_allclose(values["coefficient"], np.corrcoef(first, second)[0, 1], rtol=1e-9)
    full = np.correlate(second - second.mean(), first - first.mean(), "full") / N
    shown = full[N - 1 - 50 : N + 50]
    largest = shown[np.argmax(np.abs(shown))]
    np.testing.assert_allclose(values["peak"], np.sign(largest) * np.sqrt(abs(largest)), rtol=1e-9)


def test_chambers_that_change_places_turn_the_lag():
    first = noise(4, N)
    second = np.roll(first, 7)
    there, back = (
        measured(batch({P1: a, P2: b}), "cross_correlation")[0] for a, b in ((first, second), (second, first))
    )
    np.testing.assert_allclose(there["lag"], -back["lag"])
    np.testing.assert_allclose(there["peak"], back["peak"], rtol=1e-12)


def test_white_noise_is_not_correlated():
    values, _ = measured(batch({P1: noise(5, (50, N)), P2: noise(6, (50, N))}), "cross_correlation")
    np.testing.assert_allclose(np.sqrt(np.mean(values["coefficient"] ** 2)), 1.0 / np.sqrt(N), rtol=0.4)


@pytest.mark.parametrize("level", [0.0, 0.1, 8.1e6])
def test_a_pressure_that_does_not_move_correlates_with_nothing(level):
    values, obstacles = measured(batch({P1: noise(9, N), P2: np.full(N, level)}), "cross_correlation")
    assert all(np.isnan(value).all() for value in values.values())
    assert obstacles == ("a chamber pressure is constant",)
