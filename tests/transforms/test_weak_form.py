import numpy as np
import pytest

from hydrofdi.indicators.estimation.chamber_balance import weak_weights


def weak_integrals(samples, frequency, half):
    """∫ φ s, ∫ φ s' and ∫ φ τ s', each (n_window,)."""
    weights = np.concatenate(weak_weights(half, frequency), axis=1)
    windows = np.lib.stride_tricks.sliding_window_view(samples, 2 * half)[::half]
    return weights @ windows.T


@pytest.mark.parametrize("half", [2, 5, 8])
def test_a_ramp_has_its_slope(half):
    time = np.arange(10 * half) / 200.0
    level, slope, later = weak_integrals(3.0 + 7.0 * time, 200.0, half)
    middles = (np.arange(9) + 1) * half / 200.0
    area = half / 200.0
    np.testing.assert_allclose(level, (3.0 + 7.0 * middles) * area, rtol=1e-12)
    np.testing.assert_allclose(slope, 7.0 * area, rtol=1e-12)
    np.testing.assert_allclose(later, 0.0, atol=1e-12)


def test_a_slow_sine_gives_the_integrals_of_the_continuum():
    rate, half, frequency = 2 * np.pi * 3.0, 8, 500.0
    time = np.arange(800) / frequency
    level, slope, later = weak_integrals(np.sin(rate * time), frequency, half)
    fine = np.linspace(0.0, 2 * half / frequency, 20_001)
    weight = np.sin(np.pi * fine * frequency / (2 * half)) ** 2
    for window in (0, 17, 60):
        instant = fine + window * half / frequency
        derivative = rate * np.cos(rate * instant)
        lag = fine - half / frequency
        for found, integrand, size in (
            (level, weight * np.sin(rate * instant), 1.0),
            (slope, weight * derivative, rate),
            (later, weight * lag * derivative, rate * half / frequency),
        ):
            exact = np.trapezoid(integrand, fine)
            assert abs(found[window] - exact) < 2e-3 * size * half / frequency
