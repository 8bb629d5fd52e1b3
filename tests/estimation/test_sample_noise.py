"""The noise of a signal, beside what moves it."""

import numpy as np

from hydrofdi.indicators.estimation.valve_use import follow_noise, new_noise


def noise_of(signal, unclear=None, cuts=()):
    """Standard deviation after the last sample."""
    signal = np.atleast_2d(signal)
    unclear = np.zeros(signal.shape, dtype=bool) if unclear is None else unclear
    state = new_noise(len(signal))
    for part, mask in zip(np.split(signal, cuts, axis=1), np.split(unclear, cuts, axis=1), strict=True):
        variance = np.zeros(part.shape)
        follow_noise(np.ascontiguousarray(part), np.ascontiguousarray(mask), state, variance)
    return np.sqrt(variance[:, -1])


def test_noise_is_found_beside_a_motion_that_is_much_larger():
    time = np.arange(10_000) / 500.0
    motion = 8e6 + 2e6 * np.sin(2 * np.pi * 2.0 * time) + 1e5 * np.sin(2 * np.pi * 40.0 * time)
    noise = 5e3 * np.random.default_rng(1).normal(size=time.shape)
    np.testing.assert_allclose(noise_of(motion + noise), 5e3, rtol=0.05)


def test_samples_that_do_not_count_and_their_neighbours_leave_no_trace():
    signal = 5e3 * np.random.default_rng(2).normal(size=(1, 4000))
    jumping = signal + np.where(np.arange(4000) // 500 % 2 == 0, 8e6, 9e6)
    unclear = np.zeros(signal.shape, dtype=bool)
    unclear[:, 500::500] = True
    np.testing.assert_allclose(noise_of(jumping, unclear), 5e3, rtol=0.05)
    assert noise_of(jumping) > 1e4


def test_a_stream_gives_the_bits_of_the_record():
    signal = np.random.default_rng(3).normal(size=(2, 500))
    np.testing.assert_array_equal(noise_of(signal, cuts=[1, 2, 9, 300]), noise_of(signal))
