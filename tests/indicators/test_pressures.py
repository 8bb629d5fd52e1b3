"""Indicators of pressures alone: statistics, correlation, what follows a step, decay at rest."""

import numpy as np
import pytest
from scipy import stats

from hydrofdi.records import Channel
from indicators.signals import P1, P2, U, batch, measured, noise, square_wave

N = 3000


def test_the_numbers_are_those_of_scipy():
    record = noise(1, 4000) + 1e6 * np.sin(np.arange(4000) / 30)
    values, _ = measured(batch({P1: record}), "pressure_statistics")
    np.testing.assert_allclose(values["mean"], record.mean(), rtol=1e-13)
    np.testing.assert_allclose(values["standard_deviation"], record.std(), rtol=1e-10)
    np.testing.assert_allclose(values["increments"], np.diff(record).std(), rtol=1e-10)
    np.testing.assert_allclose(values["kurtosis"], stats.kurtosis(record, fisher=False), rtol=1e-10)
    largest = np.abs(record - record.mean()).max()
    np.testing.assert_allclose(values["crest_factor"], largest / record.std(), rtol=1e-10)
    np.testing.assert_allclose(values["peak_to_peak"], np.ptp(record), rtol=1e-13)


@pytest.mark.parametrize("level", [0.0, 8.1e6, 0.1])
def test_what_does_not_move_has_no_kurtosis_and_correlates_with_nothing(level):
    records = batch({P1: np.full(N, level), P2: noise(9, N)})
    values, obstacles = measured(records, "pressure_statistics")
    assert (values["mean"], values["standard_deviation"]) == (level, 0.0)
    assert np.isnan(values["kurtosis"]).all()
    assert obstacles == (None,)
    values, obstacles = measured(records, "cross_correlation")
    assert all(np.isnan(value).all() for value in values.values())
    assert obstacles[0]


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


AC_N, HALF = 5000, 500


def stepping(pressure):
    pressure = np.atleast_2d(pressure)
    return batch({P1: pressure, U: np.tile(square_wave(AC_N, HALF), (len(pressure), 1))})


def after_step():
    """Time since the last step [s]."""
    return (np.arange(AC_N) % HALF) / 500.0


def test_a_cubic_after_each_step_is_nothing():
    time = after_step()
    cubic = 8e6 + square_wave(AC_N, HALF) * (1e5 + 3e6 * time - 4e6 * time**2 + 2e7 * time**3)
    values, _ = measured(stepping(cubic), "post_step_ac")
    assert values["rms"][0] < 1e-6
    assert measured(stepping(cubic), "post_step_ac", trend_degree=2)[0]["rms"][0] > 1e3


def test_a_sine_of_many_periods_has_its_rms():
    record = 8e6 + 2e5 * np.sin(2 * np.pi * 60.0 * after_step())
    values, _ = measured(stepping(record), "post_step_ac")
    np.testing.assert_allclose(values["rms"], 2e5 / np.sqrt(2.0), rtol=1e-2)
    np.testing.assert_allclose(values["relative"], values["rms"] / 8e6, rtol=2e-3)


def test_white_noise_keeps_what_the_cubic_leaves_of_it():
    record = noise(1, (40, AC_N), size=1e5)
    values, _ = measured(stepping(record), "post_step_ac")
    expected = 1e5 * np.sqrt(1.0 - 4.0 / 125.0)
    np.testing.assert_allclose(values["rms"].mean(), expected, rtol=0.01)
    within = np.abs(values["rms"] - expected) < 2.306 * values["rms_error"]
    assert within.mean() > 0.8


def test_only_the_windows_after_steps_count():
    quiet = np.full(AC_N, 8e6)
    quiet[after_step() > 0.3] += 1e6
    assert measured(stepping(quiet), "post_step_ac")[0]["rms"] < 1e-6
    assert measured(stepping(quiet), "post_step_ac", delay="0.3 s")[0]["rms"] > 1e3


def test_a_record_without_steps_says_so():
    records = stepping(noise(4, (2, AC_N)))
    records[U][1] = 1.5
    values, obstacles = measured(records, "post_step_ac")
    assert np.isnan(values["rms"]).tolist() == [False, True]
    assert obstacles == (None, "no step of the drive is followed by a full window")


X = Channel.PISTON_POSITION
DECAY_N = 5000
TIME = np.arange(DECAY_N) / 500.0


def moving_then_resting():
    """Motion for 3 s, rest for 4 s, motion for 1 s, rest for 2 s."""
    return (TIME < 3.0) | ((TIME >= 7.0) & (TIME < 8.0))


def falling(rate_1, rate_2, seed=0):
    """Pressures that swing while the actuator moves and drift while it rests."""
    swing = 2e6 * np.sin(2 * np.pi * 1.7 * TIME) * moving_then_resting()
    return {
        P1: 9e6 + rate_1 * TIME + swing,
        P2: 4e6 + rate_2 * TIME - swing,
        U: 2.0 * moving_then_resting(),
        X: 0.02 * np.sin(2 * np.pi * 1.7 * TIME) * moving_then_resting(),
    }


@pytest.mark.parametrize("rest", ["command", "position", "auto"])
def test_the_drift_at_rest_comes_out_whatever_the_motion_does(rest):
    values, _ = measured(batch(falling(-3e4, 2e4)), "pressure_decay", rest=rest)
    np.testing.assert_allclose(values["chamber_1"], -3e4, rtol=1e-9)
    np.testing.assert_allclose(values["chamber_2"], 2e4, rtol=1e-9)
    np.testing.assert_allclose(values["difference"], -5e4, rtol=1e-9)


def test_a_leak_between_closed_chambers_shows_its_flow():
    """Two closed chambers of 280 cm³ and 551 MPa that leak by the orifice law: dP_1/dt = −β q/V."""
    coefficient, compliance, pressures = 1e-11, 280e-6 / 551e6, [np.array([9e6, 7e6])]
    for _ in range(DECAY_N - 1):
        flow = coefficient * np.sqrt(pressures[-1][0] - pressures[-1][1])
        pressures.append(pressures[-1] + np.array([-1.0, 1.0]) * flow / compliance / 500.0)
    first, second = np.array(pressures).T
    values, _ = measured(batch({P1: first, P2: second}), "pressure_decay", rest="whole", settling=0)
    middle = coefficient * np.sqrt(first[DECAY_N // 2] - second[DECAY_N // 2]) / compliance
    np.testing.assert_allclose(values["chamber_1"], -middle, rtol=0.01)
    np.testing.assert_allclose(values["difference"], -2 * middle, rtol=0.01)
    assert values["duration"] == 10.0


def test_noise_scatters_the_rate_as_least_squares_say():
    channels = {P1: noise(1, (200, DECAY_N), size=5e3), P2: noise(2, (200, DECAY_N), size=5e3)}
    values, _ = measured(batch(channels), "pressure_decay", rest="whole", settling=0)
    expected = 5e3 * np.sqrt(12.0 / DECAY_N) / 10.0
    np.testing.assert_allclose(values["chamber_1"].std(), expected, rtol=0.15)
    assert abs(values["chamber_1"].mean()) < 4 * expected / np.sqrt(200)


def test_one_gauge_states_the_leak_of_an_enclosed_volume():
    """1 L of oil of 1 GPa that loses 1e5 Pa/s leaks 1e-7 m³/s, by as much as its β and volume are known."""
    options = {"rest": "whole", "enclosed_volume": "1 L", "bulk_modulus": "1 GPa"}
    values, obstacles = measured(batch({P1: 5e6 - 1e5 * TIME}), "pressure_decay", **options)
    assert obstacles == (None,)
    assert np.isnan(values["chamber_2"]).all()
    np.testing.assert_allclose(values["leak"], 1e-7, rtol=1e-9)
    np.testing.assert_allclose(values["leak_error"], 1e-7 * np.hypot(0.05, 0.3), rtol=1e-9)


def test_the_interval_of_the_leak_contains_the_leak():
    """Vessels whose β and volume differ as stated, with a noisy gauge and with leaks from none to large."""
    draws, n = np.random.default_rng(5), 400
    leak = np.where(draws.random(n) < 0.3, 0.0, 10.0 ** draws.uniform(-11, -7, n))
    modulus, volume = (
        1e9 / (1.0 + 0.3 * draws.normal(size=n)).clip(0.2),
        1e-3 * (1.0 + 0.05 * draws.normal(size=n)),
    )
    pressure = 5e6 - (leak * modulus / volume)[:, None] * TIME + noise(6, (n, DECAY_N), size=2e3)
    options = {"rest": "whole", "enclosed_volume": "1 L", "bulk_modulus": "1 GPa"}
    values, _ = measured(batch({P1: pressure}), "pressure_decay", **options)
    inside = np.abs(values["leak"] - leak) <= 2.0 * values["leak_error"]
    assert 0.85 < inside.mean() < 1.0
    assert inside[leak == 0.0].mean() > 0.9


def test_a_record_without_rest_says_so_and_the_others_go_on():
    rows = [falling(-3e4, 2e4) for _ in range(3)]
    rows[1][U] = np.full(DECAY_N, 2.0)
    channels = {channel: np.stack([row[channel] for row in rows]) for channel in rows[0]}
    values, obstacles = measured(batch(channels), "pressure_decay")
    assert np.isnan(values["chamber_1"]).tolist() == [False, True, False]
    assert obstacles == (None, "no rest is long enough", None)


def test_what_settles_after_the_motion_is_left_out():
    channels = falling(-3e4, 2e4)
    since = np.where(TIME < 7.0, TIME - 3.0, TIME - 8.0)
    channels[P1] = channels[P1] + np.where(moving_then_resting(), 0.0, 1e6 * np.exp(-since / 0.05))
    early, late = (measured(batch(channels), "pressure_decay", settling=s)[0] for s in (0.05, 1.0))
    assert early["chamber_1"] < -3.5e4
    np.testing.assert_allclose(late["chamber_1"], -3e4, rtol=1e-3)
    assert (early["duration"], late["duration"]) == (5.9, 4.0)


def test_a_command_in_counts_tells_no_rest_and_a_position_tells_it_by_its_range():
    channels = falling(-3e4, 2e4)
    counts = batch(channels, relative=frozenset({U}))
    by_position, _ = measured(counts, "pressure_decay")
    assert by_position["duration"] == measured(counts, "pressure_decay", rest="position")[0]["duration"]
    assert measured(counts, "pressure_decay", rest="command")[1][0]
    del channels[U]
    counts = batch({**channels, X: 1e5 * channels[X]}, relative=frozenset({X}))
    for name, value in measured(batch(channels), "pressure_decay")[0].items():
        np.testing.assert_allclose(measured(counts, "pressure_decay")[0][name], value, rtol=1e-9)
