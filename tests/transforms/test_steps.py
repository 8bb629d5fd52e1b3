"""Steps of the drive: found where they are, whoever tells of them."""

import numpy as np
import pytest

from hydrofdi.indicators.stepping import half_periods, jumps


def square(n_time, period, rng=None, noise=0.0):
    wave = np.where(np.arange(n_time) % period < period // 2, 2.0, -2.0)
    return wave + (0.0 if rng is None else noise * rng.normal(size=n_time))


def test_the_jumps_of_a_square_wave_are_its_half_periods():
    found, expected = jumps(square(10_000, 1000)[None], 5, 50, 8.0), half_periods(1, 10_000, 500.0, 2.0)
    np.testing.assert_array_equal(found.sample, np.arange(500, 10_000, 500))
    np.testing.assert_array_equal(found.sample, expected.sample)


def test_a_later_start_moves_the_half_periods():
    whole = half_periods(1, 5000, 500.0, 0.7).sample
    for first in (1, 100, 175, 350):
        part = half_periods(1, 5000 - first, 500.0, 0.7, first / 500.0).sample
        np.testing.assert_array_equal(part + first, whole[whole > first])


def test_noise_moves_no_jump_and_makes_none():
    rng = np.random.default_rng(1)
    noisy = jumps(square(5000, 1000, rng, 0.2)[None], 5, 50, 8.0)
    np.testing.assert_array_equal(noisy.sample, np.arange(500, 5000, 500))
    assert jumps(rng.normal(size=(20, 5000)), 5, 50, 8.0).sample.size == 0


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


def test_the_largest_changes_of_a_ringing_signal_are_the_steps():
    time = (np.arange(10_000) % 500) / 500.0
    rings = 1.0 - np.exp(-8.0 * time) * np.cos(375.0 * time) + 3.0 * time
    found = jumps((square(10_000, 1000) * rings)[None], 5, 100)
    late = found.sample - np.arange(500 if found.sample.size == 19 else 0, 10_000, 500)
    assert 0 <= late.min() <= late.max() <= 5


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
