import numpy as np

from indicators.laws import noise
from indicators.signals import P1, U, batch, measured, square_wave

N, HALF = 5000, 500


def stepping(pressure):
    pressure = np.atleast_2d(pressure)
    return batch({P1: pressure, U: np.tile(square_wave(N, HALF), (len(pressure), 1))})


def after_step():
    """Time since the last step [s]."""
    return (np.arange(N) % HALF) / 500.0


def test_a_cubic_after_each_step_is_nothing():
    time = after_step()
    cubic = 8e6 + square_wave(N, HALF) * (1e5 + 3e6 * time - 4e6 * time**2 + 2e7 * time**3)
    values, _ = measured(stepping(cubic), "post_step_ac")
    assert values["rms"][0] < 1e-6
    assert measured(stepping(cubic), "post_step_ac", trend_degree=2)[0]["rms"][0] > 1e3


def test_a_sine_of_many_periods_has_its_rms():
    record = 8e6 + 2e5 * np.sin(2 * np.pi * 60.0 * after_step())
    values, _ = measured(stepping(record), "post_step_ac")
    np.testing.assert_allclose(values["rms"], 2e5 / np.sqrt(2.0), rtol=1e-2)
    np.testing.assert_allclose(values["relative"], values["rms"] / 8e6, rtol=2e-3)


def test_white_noise_keeps_what_the_cubic_leaves_of_it():
    record = noise(1, (40, N), size=1e5)
    values, _ = measured(stepping(record), "post_step_ac")
    expected = 1e5 * np.sqrt(1.0 - 4.0 / 125.0)
    np.testing.assert_allclose(values["rms"].mean(), expected, rtol=0.01)
    within = np.abs(values["rms"] - expected) < 2.306 * values["rms_error"]
    assert within.mean() > 0.8


def test_only_the_windows_after_steps_count():
    quiet = np.full(N, 8e6)
    quiet[after_step() > 0.3] += 1e6
    assert measured(stepping(quiet), "post_step_ac")[0]["rms"] < 1e-6
    assert measured(stepping(quiet), "post_step_ac", delay="0.3 s")[0]["rms"] > 1e3


def test_a_record_without_steps_says_so():
    records = stepping(noise(4, (2, N)))
    records[U][1] = 1.5
    values, obstacles = measured(records, "post_step_ac")
    assert np.isnan(values["rms"]).tolist() == [False, True]
    assert obstacles == (None, "no step of the drive is followed by a full window")
