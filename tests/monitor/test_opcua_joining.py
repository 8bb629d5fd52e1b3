from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.monitor.opcua.source import Joiner, NodeValue

PERIOD = 0.01


def values_of(samples, spread=0.0):
    """Samples (n_time, n_node) as values, the stamps of each node late by its position times `spread`."""
    return [
        NodeValue(row * PERIOD + node * spread, node, float(value), row * PERIOD)
        for row, sample in enumerate(samples)
        for node, value in enumerate(sample)
    ]


def joined(joiner, messages):
    parts = [joiner.add(message, now=0.0) for message in messages]
    return np.concatenate([time for time, _ in parts]), np.concatenate([samples for _, samples in parts])


@given(
    n_time=st.integers(1, 40),
    spread=st.sampled_from([0.0, 0.002, 0.0024]),
    cuts=st.lists(st.integers(0, 120), max_size=6),
)
def test_the_cut_into_messages_does_not_matter(n_time, spread, cuts):
    samples = np.arange(3.0 * n_time).reshape(n_time, 3)
    values = values_of(samples, spread)
    edges = [0, *sorted(min(cut, len(values)) for cut in cuts), len(values)]
    messages = [values[a:b] for a, b in pairwise(edges)]
    time, found = joined(Joiner(3, PERIOD, wait=1.0), messages)
    np.testing.assert_array_equal(found, samples)
    np.testing.assert_array_equal(time, PERIOD * np.arange(n_time))


def test_an_instant_that_a_node_misses_is_given_with_nan_when_the_node_goes_on():
    values = values_of(np.arange(40.0).reshape(20, 2))
    without = [value for value in values if value[:2] != (5 * PERIOD, 1)]
    joiner = Joiner(2, PERIOD, wait=1000.0)
    assert joiner.add(without[:11], now=0.0)[0].size == 5
    time, samples = joiner.add(without[11:], now=0.0)
    assert time.size == 15
    assert samples[0, 0] == 10.0
    assert np.isnan(samples[0, 1])
    assert not np.isnan(samples[1:]).any()


def test_a_node_that_falls_silent_is_waited_for_and_does_not_stop_the_stream():
    joiner = Joiner(2, PERIOD, wait=0.1)
    joiner.add(values_of(np.zeros((1, 2))), now=0.0)
    alone = [NodeValue(row * PERIOD, 0, float(row), row * PERIOD) for row in range(1, 1000)]
    given = [joiner.add([value], now=value.arrival)[0].size for value in alone]
    assert sum(given[:10]) == 0
    assert 980 <= sum(given) <= 990


def test_a_connection_begins_with_the_first_whole_instant():
    values = values_of(np.arange(20.0).reshape(10, 2))
    time, samples = joined(Joiner(2, PERIOD, wait=0.02), [values[1:2], values[2:3], values[4:]])
    assert samples[0].tolist() == [4.0, 5.0]
    assert time.size == 8


def test_time_that_runs_back_is_left_to_the_stream_to_judge():
    joiner = Joiner(2, PERIOD, wait=0.05)
    later = [value._replace(time=value.time + 3600.0) for value in values_of(np.ones((10, 2)))]
    assert joiner.add(later, now=0.0)[0].size == 10
    assert joiner.add(values_of(np.ones((10, 2))), now=0.0)[0].size == 10
