"""Delays from the onset of a leak to the alarm."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.run_lengths import Delays, delays


def shewhart():
    return make_chart("moving_window", {"window": 1, "direction": "rising"})


def test_delays_by_hand():
    scores = np.array(
        [
            [0, 0, 0, 9, 0, 9],  # found at once
            [0, 9, 0, 0, 0, 9],  # a false alarm, then found
            [9, 9, 0, 0, 0, 0],  # false alarms alone: not found
            [0, 0, 0, np.nan, np.nan, np.nan],  # nothing to find it by
        ]
    )
    found = delays(shewhart(), 5.0, scores, 0.1 * np.arange(6), 0.3)
    np.testing.assert_allclose(found.values, [0.0, 0.2, np.inf, np.inf], atol=1e-12)
    np.testing.assert_array_equal(found.n_early, [0, 1, 2, 0])
    assert (found.not_measurable, found.found.count, found.found.total) == (1, 2, 4)


def test_each_stream_may_have_its_own_onset():
    scores = np.array([[9.0, 0, 0, 9, 0], [9, 0, 0, 9, 0]])
    found = delays(shewhart(), 5.0, scores, np.arange(5.0), [0.0, 1.0])
    np.testing.assert_array_equal(found.values, [0.0, 2.0])


def test_a_false_alarm_does_not_speed_up_the_detection():
    """The chart starts anew after it: what it had summed before the onset is gone."""
    scores = np.array([[3.0, 0, 0.9, 0.9, 0.9, 0.9, 0.9]])
    found = delays(make_chart("cusum"), 1.5, scores, np.arange(7.0), 2.0)
    np.testing.assert_array_equal(found.n_early, [1])
    np.testing.assert_array_equal(found.values, [3.0])


def test_mean_delays_are_run_lengths():
    draw = np.random.default_rng(1)
    found = delays(make_chart("cusum"), 5.0, 1.0 + draw.standard_normal((4000, 100)), np.arange(100.0), 0.0)
    error = found.values.std() / np.sqrt(4000)
    assert abs(found.values.mean() + 1.0 - 10.37597) < 3.0 * error


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_intervals_of_quantiles_cover(share):
    truth, held = -np.log(1.0 - share), 0
    for seed in range(200):
        drawn = Delays(np.random.default_rng(seed).exponential(size=60), np.zeros(60, dtype=int), 0)
        quantile = drawn.quantile(share)
        assert quantile.low <= quantile.value <= quantile.high
        held += quantile.low <= truth <= quantile.high
    assert 182 <= held <= 200


def test_leaks_that_are_not_found_make_quantiles_infinite():
    found = Delays(np.array([1.0] * 6 + [np.inf] * 4), np.zeros(10, dtype=int), 0)
    assert found.quantile(0.5).value == 1.0
    assert found.quantile(0.5).high == found.quantile(0.9).value == np.inf
