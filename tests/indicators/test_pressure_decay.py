import numpy as np
import pytest

from hydrofdi.records import Channel
from indicators.laws import noise
from indicators.signals import P1, P2, U, batch, measured

X = Channel.PISTON_POSITION
N = 5000
TIME = np.arange(N) / 500.0


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


def test_settling_is_left_out_of_the_time_at_rest():
    channels = falling(-3e4, 2e4)
    assert measured(batch(channels), "pressure_decay", settling="0.5 s")[0]["duration"] == 5.0
    assert measured(batch(channels), "pressure_decay", settling="2.5 s")[0]["duration"] == 1.5


def test_a_rest_test_is_taken_as_a_whole():
    channels = {P1: 5e6 - 1e5 * TIME, P2: 8e6 + 1e5 * TIME}
    values, _ = measured(batch(channels), "pressure_decay", rest="whole", settling=0)
    np.testing.assert_allclose(values["chamber_1"], -1e5, rtol=1e-9)
    np.testing.assert_allclose(values["difference"], 2e5, rtol=1e-9)
    assert values["duration"] == 10.0


def test_a_leak_between_closed_chambers_shows_its_flow():
    """Two closed chambers of 280 cm³ and 551 MPa that leak by the orifice law: dP_1/dt = −β q/V."""
    coefficient, compliance, pressures = 1e-11, 280e-6 / 551e6, [np.array([9e6, 7e6])]
    for _ in range(N - 1):
        flow = coefficient * np.sqrt(pressures[-1][0] - pressures[-1][1])
        pressures.append(pressures[-1] + np.array([-1.0, 1.0]) * flow / compliance / 500.0)
    first, second = np.array(pressures).T
    values, _ = measured(batch({P1: first, P2: second}), "pressure_decay", rest="whole", settling=0)
    middle = coefficient * np.sqrt(first[N // 2] - second[N // 2]) / compliance
    np.testing.assert_allclose(values["chamber_1"], -middle, rtol=0.01)
    np.testing.assert_allclose(values["difference"], -2 * middle, rtol=0.01)


def test_noise_scatters_the_rate_as_least_squares_say():
    channels = {P1: noise(1, (200, N), size=5e3), P2: noise(2, (200, N), size=5e3)}
    values, _ = measured(batch(channels), "pressure_decay", rest="whole", settling=0)
    expected = 5e3 * np.sqrt(12.0 / N) / 10.0
    np.testing.assert_allclose(values["chamber_1"].std(), expected, rtol=0.15)
    assert abs(values["chamber_1"].mean()) < 4 * expected / np.sqrt(200)


def test_a_record_without_rest_says_so_and_the_others_go_on():
    rows = [falling(-3e4, 2e4) for _ in range(3)]
    rows[1][U] = np.full(N, 2.0)
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


def test_a_command_in_counts_tells_no_rest():
    channels = falling(-3e4, 2e4)
    counts = batch(channels, relative=frozenset({U}))
    by_position, _ = measured(counts, "pressure_decay")
    assert by_position["duration"] == measured(counts, "pressure_decay", rest="position")[0]["duration"]
    assert "has no scale" in measured(counts, "pressure_decay", rest="command")[1][0]


def test_a_position_in_counts_tells_the_rest_by_its_range():
    channels = falling(-3e4, 2e4)
    del channels[U]
    counts = batch({**channels, X: 1e5 * channels[X]}, relative=frozenset({X}))
    for name, value in measured(batch(channels), "pressure_decay")[0].items():
        np.testing.assert_allclose(measured(counts, "pressure_decay")[0][name], value, rtol=1e-9)
