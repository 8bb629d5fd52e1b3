"""The weak form, free motion and steps."""

import numpy as np
import pytest

from hydrofdi.indicators.catalogue.ring_down import fit_free_motion
from hydrofdi.indicators.catalogue.transients import half_periods, jumps
from hydrofdi.indicators.estimation.chamber_balance import weak_weights


def weak_integrals(samples, frequency, half):
    """∫ φ s, ∫ φ s' and ∫ φ τ s', each (n_window,)."""
    weights = np.concatenate(weak_weights(half, frequency), axis=1)
    windows = np.lib.stride_tricks.sliding_window_view(samples, 2 * half)[::half]
    return weights @ windows.T


def test_a_slow_sine_gives_the_integrals_of_the_continuum():
    rate, half, frequency = 2 * np.pi * 3.0, 8, 500.0
    found = weak_integrals(np.sin(rate * np.arange(800) / frequency), frequency, half)
    fine, area = np.linspace(0.0, 2 * half / frequency, 20_001), half / frequency
    weight = np.sin(np.pi * fine / (2.0 * area)) ** 2
    for window in (0, 17, 60):
        sine, slope = np.sin(rate * (fine + window * area)), rate * np.cos(rate * (fine + window * area))
        integrands = weight * sine, weight * slope, weight * (fine - area) * slope
        for numbers, integrand, size in zip(found, integrands, (1.0, rate, rate * area), strict=True):
            assert abs(numbers[window] - np.trapezoid(integrand, fine)) < 2e-3 * size * area


TIME = np.arange(120) / 120.0


def motion(frequency, damping_ratio, seed, n_piece=6):
    """Pieces of the free motion from random states; frequency in cycles per piece."""
    natural = 2.0 * np.pi * frequency
    root = natural * np.sqrt(complex(damping_ratio**2 - 1.0))
    draw, decay = np.random.default_rng(seed), np.exp(-damping_ratio * natural * TIME)
    shapes = np.stack((np.cosh(root * TIME).real, (natural * np.sinh(root * TIME) / root).real))
    return decay * (draw.normal(size=(n_piece, 2)) @ shapes)


@pytest.mark.parametrize(("frequency", "damping_ratio"), [(12.0, 0.05), (6.0, 0.3), (4.0, 0.5), (1.5, 1.6)])
def test_least_squares_find_it_beside_a_polynomial(frequency, damping_ratio):
    pieces = 5.0 + 3.0 * TIME - 2.0 * TIME**2 + motion(frequency, damping_ratio, 3)
    found = fit_free_motion(pieces, np.zeros(6, dtype=np.intp), 1200.0, 2)
    np.testing.assert_allclose(found.frequency, 10.0 * frequency, rtol=1e-6)
    np.testing.assert_allclose(found.damping_ratio, damping_ratio, rtol=1e-6)
    np.testing.assert_allclose(found.explained, 1.0, rtol=1e-9)


def square(n_time, period, rng=None, noise=0.0):
    wave = np.where(np.arange(n_time) % period < period // 2, 2.0, -2.0)
    return wave + (0.0 if rng is None else noise * rng.normal(size=n_time))


def test_the_jumps_of_a_square_wave_are_its_half_periods_with_noise_and_from_any_start():
    draw = np.random.default_rng(1)
    for noise in (0.0, 0.2):
        found = jumps(square(5000, 1000, draw, noise)[None], 5, 50, 8.0)
        np.testing.assert_array_equal(found.sample, np.arange(500, 5000, 500))
    np.testing.assert_array_equal(found.sample, half_periods(1, 5000, 500.0, 2.0).sample)
    assert jumps(draw.normal(size=(20, 5000)), 5, 50, 8.0).sample.size == 0
    whole = half_periods(1, 5000, 500.0, 0.7).sample
    for first in (1, 100, 175, 350):
        part = half_periods(1, 5000 - first, 500.0, 0.7, first / 500.0).sample
        np.testing.assert_array_equal(part + first, whole[whole > first])


@pytest.mark.parametrize(
    "samples", [np.full(500, 3.0), np.sin(np.arange(5000) / 100), np.full(500, np.nan), []]
)
def test_what_does_not_jump_has_no_jumps(samples):
    assert jumps(np.atleast_2d(np.asarray(samples, dtype=float)), 5, 50, 8.0).sample.size == 0


def test_a_jump_that_takes_a_while_and_rings_counts_once():
    slow = np.interp(np.arange(3000), [1000, 1005], [0.0, 1.0])
    ringing = slow + np.where(np.arange(3000) > 1005, 0.4 * np.sin(np.arange(3000)), 0.0)
    for record in (slow, ringing):
        found = jumps(record[None], 5, 4000)
        assert found.sample.size == 1
        assert 1000 < found.sample[0] <= 1006


def test_a_window_ends_before_the_next_step_and_the_record():
    steps = jumps(np.stack([square(1000, 400), square(1000, 600)]), 1, 10)
    ramp = np.stack([np.arange(1000.0), 1000.0 + np.arange(1000.0)])
    kept = steps.with_window(3, 250, 1000)
    np.testing.assert_array_equal(kept.record, [1, 1])
    pieces = kept.windows(ramp, 3, 250)
    np.testing.assert_array_equal(pieces[:, 0], [1303.0, 1603.0])
    np.testing.assert_array_equal(np.diff(pieces), 1.0)
    np.testing.assert_array_equal(kept.sums(pieces[:, 0], 2), [0.0, 2906.0])
    np.testing.assert_array_equal(kept.counts(2), [0, 2])
