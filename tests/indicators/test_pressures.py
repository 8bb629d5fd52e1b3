"""Indicators of pressures alone: statistics, correlation, what follows a step, decay at rest."""

import numpy as np
import pytest
from scipy import stats

from hydrofdi.records import Channel
from indicators.signals import P1, P2, U, batch, measured, noise, square_wave

X = Channel.PISTON_POSITION
N, HALF = 5000, 500
TIME = np.arange(N) / 500.0


def test_statistics_are_those_of_scipy_and_a_correlation_that_of_numpy():
    first = noise(1, N) + 1e6 * np.sin(np.arange(N) / 30)
    second = noise(3, N) + 0.5 * np.roll(first, 20)
    records = batch({P1: first, P2: second})
    expected = {
        "mean": first.mean(), "standard_deviation": first.std(), "increments": np.diff(first).std(),
        "kurtosis": stats.kurtosis(first, fisher=False), "peak_to_peak": np.ptp(first),
        "crest_factor": np.abs(first - first.mean()).max() / first.std(),
    }  # fmt: skip
    for name, value in measured(records, "pressure_statistics")[0].items():
        np.testing.assert_allclose(value, expected[name], rtol=1e-10, err_msg=name)
    values, _ = measured(records, "cross_correlation")
    np.testing.assert_allclose(values["coefficient"], np.corrcoef(first, second)[0, 1], rtol=1e-9)
    full = np.correlate(second - second.mean(), first - first.mean(), "full") / N
    shown = full[N - 1 - 50 : N + 50]
    largest = shown[np.argmax(np.abs(shown))]
    np.testing.assert_allclose(values["peak"], np.sign(largest) * np.sqrt(abs(largest)), rtol=1e-9)


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


@pytest.mark.parametrize("delay", [-37, 0, 5, 50])
def test_the_lag_of_a_delayed_pressure_is_its_delay(delay):
    white = noise(1, N + 100, mean=0.0)
    first, second = 8e6 + white[50 : 50 + N], 8e6 - white[50 - delay : 50 - delay + N]
    values, _ = measured(batch({P1: first, P2: second}), "cross_correlation")
    np.testing.assert_allclose(values["lag"], delay / 500.0)
    np.testing.assert_allclose(values["peak_coefficient"], -1.0, atol=0.03)
    np.testing.assert_allclose(values["peak"], -1e5, rtol=0.03)


def after_steps(pressure, **options):
    """Numbers of what follows steps that come every second, and why there are none."""
    rows = np.atleast_2d(pressure)
    records = batch({P1: rows, U: np.tile(square_wave(N, HALF), (len(rows), 1))})
    return measured(records, "post_step_ac", **options)[0]


def test_after_each_step_a_cubic_is_nothing_and_a_sine_of_many_periods_has_its_rms():
    since = TIME % 1.0
    cubic = 8e6 + square_wave(N, HALF) * (1e5 + 3e6 * since - 4e6 * since**2 + 2e7 * since**3)
    assert after_steps(cubic)["rms"][0] < 1e-6
    assert after_steps(cubic, trend_degree=2)["rms"][0] > 1e3
    values = after_steps(8e6 + 2e5 * np.sin(2 * np.pi * 60.0 * since))
    np.testing.assert_allclose(values["rms"], 2e5 / np.sqrt(2.0), rtol=1e-2)
    np.testing.assert_allclose(values["relative"], values["rms"] / 8e6, rtol=2e-3)
    late = np.where(since > 0.3, 9e6, 8e6)
    assert after_steps(late)["rms"] < 1e-6
    assert after_steps(late, delay="0.3 s")["rms"] > 1e3


def test_white_noise_keeps_what_the_cubic_leaves_of_it():
    values, expected = after_steps(noise(1, (40, N), size=1e5)), 1e5 * np.sqrt(1.0 - 4.0 / 125.0)
    np.testing.assert_allclose(values["rms"].mean(), expected, rtol=0.01)
    within = np.abs(values["rms"] - expected) < 2.306 * values["rms_error"]
    assert within.mean() > 0.8


MOVES = (TIME < 3.0) | ((TIME >= 7.0) & (TIME < 8.0))
SWING = np.sin(2 * np.pi * 1.7 * TIME) * MOVES


def falling(first=0.0):
    """Pressures that swing while the actuator moves, and drift while it rests for 4 s and 2 s."""
    pressures = {P1: 9e6 - 3e4 * TIME + 2e6 * SWING + first, P2: 4e6 + 2e4 * TIME - 2e6 * SWING}
    return pressures | {U: 2.0 * MOVES, X: 0.02 * SWING}


@pytest.mark.parametrize("rest", ["command", "position", "auto"])
def test_the_drift_at_rest_comes_out_whatever_the_motion_does(rest):
    values, _ = measured(batch(falling()), "pressure_decay", rest=rest)
    for name, rate in (("chamber_1", -3e4), ("chamber_2", 2e4), ("difference", -5e4)):
        np.testing.assert_allclose(values[name], rate, rtol=1e-9)


WHOLE = {"rest": "whole", "settling": 0}


def test_a_leak_between_closed_chambers_shows_its_flow():
    """Two closed chambers of 280 cm³ and 551 MPa that leak by the orifice law: dP_1/dt = −β q/V."""
    coefficient, compliance, pressures = 1e-11, 280e-6 / 551e6, [np.array([9e6, 7e6])]
    for _ in range(N - 1):
        flow = coefficient * np.sqrt(pressures[-1][0] - pressures[-1][1])
        pressures.append(pressures[-1] + np.array([-1.0, 1.0]) * flow / compliance / 500.0)
    first, second = np.array(pressures).T
    values, _ = measured(batch({P1: first, P2: second}), "pressure_decay", **WHOLE)
    middle = coefficient * np.sqrt(first[N // 2] - second[N // 2]) / compliance
    np.testing.assert_allclose(values["chamber_1"], -middle, rtol=0.01)
    np.testing.assert_allclose(values["difference"], -2 * middle, rtol=0.01)
    assert values["duration"] == 10.0


ENCLOSED = {"rest": "whole", "enclosed_volume": "1 L", "bulk_modulus": "1 GPa"}


def test_one_gauge_states_the_leak_of_an_enclosed_volume():
    """1 L of oil of 1 GPa that loses 1e5 Pa/s leaks 1e-7 m³/s, by as much as its β and volume are known."""
    values, obstacles = measured(batch({P1: 5e6 - 1e5 * TIME}), "pressure_decay", **ENCLOSED)
    assert obstacles == (None,)
    assert np.isnan(values["chamber_2"]).all()
    np.testing.assert_allclose(values["leak"], 1e-7, rtol=1e-9)
    np.testing.assert_allclose(values["leak_error"], 1e-7 * np.hypot(0.05, 0.3), rtol=1e-9)


def test_the_interval_of_the_leak_contains_the_leak():
    """Vessels whose β and volume differ as stated, with a noisy gauge and with leaks from none to large."""
    draws, n = np.random.default_rng(5), 400
    leak = np.where(draws.random(n) < 0.3, 0.0, 10.0 ** draws.uniform(-11, -7, n))
    modulus = 1e9 / (1.0 + 0.3 * draws.normal(size=n)).clip(0.2)
    volume = 1e-3 * (1.0 + 0.05 * draws.normal(size=n))
    pressure = 5e6 - (leak * modulus / volume)[:, None] * TIME + noise(6, (n, N), size=2e3)
    values, _ = measured(batch({P1: pressure}), "pressure_decay", **ENCLOSED)
    inside = np.abs(values["leak"] - leak) <= 2.0 * values["leak_error"]
    assert 0.85 < inside.mean() < 1.0
    assert inside[leak == 0.0].mean() > 0.9


@pytest.mark.parametrize(
    ("name", "score", "reason"),
    [
        ("pressure_decay", "chamber_1", "no rest is long enough"),
        ("post_step_ac", "rms", "no step of the drive is followed by a full window"),
    ],
)
def test_a_record_without_rest_or_steps_says_so_and_the_others_go_on(name, score, reason):
    records = batch({channel: np.tile(row, (3, 1)) for channel, row in falling().items()})
    records[U][1] = 2.0
    records[U][[0, 2]] = 2.0 * MOVES
    values, obstacles = measured(records, name)
    assert np.isnan(values[score]).tolist() == [False, True, False]
    assert obstacles == (None, reason, None)


def test_what_settles_after_the_motion_is_left_out():
    since = np.where(TIME < 7.0, TIME - 3.0, TIME - 8.0)
    records = batch(falling(np.where(MOVES, 0.0, 1e6 * np.exp(-since / 0.05))))
    early, late = (measured(records, "pressure_decay", settling=s)[0] for s in (0.05, 1.0))
    assert early["chamber_1"] < -3.5e4
    np.testing.assert_allclose(late["chamber_1"], -3e4, rtol=1e-3)
    assert (early["duration"], late["duration"]) == (5.9, 4.0)


def test_a_command_in_counts_tells_no_rest_and_a_position_tells_it_by_its_range():
    channels = falling()
    counts = batch(channels, relative=frozenset({U}))
    by_position, _ = measured(counts, "pressure_decay")
    assert by_position["duration"] == measured(counts, "pressure_decay", rest="position")[0]["duration"]
    assert measured(counts, "pressure_decay", rest="command")[1][0]
    del channels[U]
    counts = batch({**channels, X: 1e5 * channels[X]}, relative=frozenset({X}))
    found, _ = measured(counts, "pressure_decay")
    for name, value in measured(batch(channels), "pressure_decay")[0].items():
        np.testing.assert_allclose(found[name], value, rtol=1e-9)
