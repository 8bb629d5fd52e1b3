"""Samples that come one sensor at a time are those of a stream that sends them together."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk, Joining

RATE, N_TIME = 100.0, 60
CHANNELS = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.INPUT_VOLTAGE
NAMES = "P1 [bar]", "P2 [bar]", "u [V]"
TIME = np.arange(N_TIME) / RATE
VALUES = np.random.default_rng(5).normal(80.0, 5.0, (3, N_TIME))


def message(channel, *places):
    found = {"time": [TIME[n] for n in places], NAMES[channel]: [VALUES[channel, n] for n in places]}
    return json.dumps(found).encode()


def joined(messages, sizes=(10**6,)):
    """Samples of messages that come so many at once."""
    reader, joining = PayloadReader(MonitorConfig()), Joining(RATE, CHANNELS)
    state, found, first = joining.start(), [], 0
    while first < len(messages):
        for size in sizes:
            if some := messages[first : first + size]:
                state, chunk = joining.step(state, reader.read_all(some))
                found += [chunk] * bool(chunk.n_time)
                first += size
    rest = joining.step(state, Chunk(np.empty(0), {}), is_end=True)[1]
    found += [rest] * bool(rest.n_time)
    whole = [np.concatenate([each.channels[channel] for each in found]) for channel in CHANNELS]
    return np.concatenate([each.time for each in found]), np.array(whole)


ORDERS = {
    "by instant": [message(c, n) for n in range(N_TIME) for c in range(3)],
    "in turn": [message((c + n) % 3, n) for n in range(N_TIME) for c in range(3)],
    "a block of each": [
        message(c, *range(n, min(n + 7, N_TIME))) for n in range(0, N_TIME, 7) for c in range(3)
    ],
    "one late": [message(0, *range(N_TIME)), *(message(c, n) for n in range(N_TIME) for c in (1, 2))],
    "stamps within half a period": [
        json.dumps({"time": TIME[n] + 0.001 * c, NAMES[c]: VALUES[c, n]}).encode()
        for n in range(N_TIME) for c in range(3)
    ],
}  # fmt: skip


@pytest.mark.parametrize("order", ORDERS)
@given(sizes=st.lists(st.integers(1, 9), min_size=1, max_size=5))
def test_one_sensor_in_a_message_gives_the_whole_samples(order, sizes):
    time, values = joined(ORDERS[order], sizes)
    np.testing.assert_array_equal(time, TIME)
    np.testing.assert_allclose(values, VALUES * np.array([[1e5], [1e5], [1.0]]), rtol=1e-15)


def test_a_channel_that_is_left_out_or_ends_is_missing_there_alone():
    left = [message(c, n) for n in range(N_TIME) for c in range(3) if (c, n) != (1, 20) and (c < 2 or n < 40)]
    time, values = joined(left)
    np.testing.assert_array_equal(time, TIME)
    missing = np.zeros(values.shape, dtype=bool)
    missing[1, 20] = missing[2, 40:] = True
    np.testing.assert_array_equal(np.isnan(values), missing)


def test_a_dead_channel_delays_samples_by_two_seconds_at_most():
    joining, state, n_ready = Joining(RATE, CHANNELS), Joining(RATE, CHANNELS).start(), 0
    for n in range(500):
        state, chunk = joining.step(state, Chunk(np.array([n / RATE]), {CHANNELS[0]: np.ones(1)}))
        n_ready += chunk.n_time
    assert n_ready == 500 - len(state["rows"]) > 290


def test_samples_that_came_twice_stay_two():
    twice = [message(c, n) for n in range(N_TIME) for c in range(3) for _ in range(1 + (n == 30))]
    time, _ = joined(twice)
    assert np.count_nonzero(time == TIME[30]) == 2
