"""Laws of every chart, and what each of them is for."""

import numpy as np
import pytest

from hydrofdi.detectors.charts import Delays, FalseAlarms, delays, operations
from hydrofdi.detectors.rules import chart_names, make_chart
from hydrofdi.errors import NotStatedError
from tests.detectors.trained.healthy import autoregressive

SHORT = {"glr": {"window": 20}}


def short(name, **options):
    return make_chart(name, {**SHORT.get(name, {}), **options})


SCORES = np.random.default_rng(1).standard_normal((5, 400))
SCORES[1, 100:120], SCORES[3, 7] = np.nan, np.inf
SCORES[2, 200:] += 1.5

every_chart = pytest.mark.parametrize("name", chart_names())


@pytest.mark.parametrize("limit", [np.inf, 2.0])
@every_chart
def test_a_stream_gives_the_bits_of_the_whole_whatever_its_neighbours_and_keeps_old_states(name, limit):
    chart = short(name)
    whole = chart.follow(SCORES, limit)
    np.testing.assert_array_equal(np.vstack([chart.follow(row[None], limit) for row in SCORES]), whole)
    for size in (1, 7, 133):
        state, parts = chart.start(5), []
        for first in range(0, 400, size):
            before = {key: values.copy() for key, values in state.items()}
            after, statistic = chart.step(state, SCORES[:, first : first + size], limit)
            assert all(np.array_equal(values, before[key]) for key, values in state.items())
            state = after
            parts.append(statistic)
        np.testing.assert_array_equal(np.hstack(parts), whole)


@every_chart
def test_nan_scores_are_passed_over_and_infinite_ones_are_the_largest(name):
    statistic = short(name, direction="rising").follow(SCORES)
    assert np.isfinite(statistic[3, 10:]).all()
    assert statistic[3, 10] > 1e3
    hole, found = slice(100, 120), short(name).follow(SCORES[1:2])
    assert np.isnan(found[:, hole]).all()
    kept = np.delete(SCORES[1:2], hole, axis=1)
    np.testing.assert_array_equal(np.delete(found, hole, axis=1), short(name).follow(kept))


@every_chart
def test_directions_are_mirrored_and_a_chart_starts_anew_after_an_alarm(name):
    scores = np.random.default_rng(3).standard_normal((2, 200))
    rising, falling, both = (short(name, direction=each) for each in ("rising", "falling", "both"))
    np.testing.assert_array_equal(rising.follow(scores), falling.follow(-scores))
    largest = np.maximum(rising.follow(scores), falling.follow(scores))
    np.testing.assert_array_equal(both.follow(scores), largest)
    scores, limit = 1.5 + scores[:1], 1.7
    statistic = rising.follow(scores, limit)
    after = int(np.argmax(statistic >= limit)) + 1
    assert np.nanmax(statistic) >= limit
    np.testing.assert_array_equal(statistic[:, after:], rising.follow(scores[:, after:], limit))


def test_cusum_sums_by_hand():
    statistic = make_chart("cusum", {"direction": "rising"}).follow([[1.0, 2.0, -3.0, 0.75]])
    np.testing.assert_allclose(statistic, [[0.5, 2.0, 0.0, 0.25]])


@pytest.mark.parametrize("weight", [0.05, 0.5])
def test_ewma_has_unit_variance_at_every_instant(weight):
    statistic = make_chart("ewma", {"direction": "rising", "weight": weight}).follow(
        np.random.default_rng(5).standard_normal((20000, 60))
    )
    np.testing.assert_allclose(statistic.std(axis=0), 1.0, atol=5 / np.sqrt(2 * 20000))


def test_glr_is_the_best_change_of_all_windows():
    scores = np.random.default_rng(6).standard_normal((1, 50))
    statistic = make_chart("glr", {"window": 12}).follow(scores)
    for instant in range(50):
        sums = np.cumsum(scores[0, instant::-1])[:12]
        best = np.max(sums**2 / (2.0 * np.arange(1, sums.size + 1)))
        assert statistic[0, instant] == pytest.approx(best, rel=1e-12)


INTERVAL = 0.1


@pytest.mark.parametrize(
    ("memory", "between", "n_stream", "wanted"),
    [(0.5, 0.0, 60, 60.0), (0.8, 0.5, 60, 200.0), (0.5, 0.5, 300, 600.0)],
    ids=["dependent", "records that differ", "few alarms"],
)
def test_the_interval_of_the_mean_time_covers_it(memory, between, n_stream, wanted):
    """The truth is counted over 60,000 seconds of the same kind."""
    chart = make_chart("cusum")
    long = dependent(999, 600_000 // 100, 100, memory, between)
    held, inverse = 0, []
    for seed in range(60):
        limit = cusum(dependent(seed, n_stream, 100, memory, between), INTERVAL, n_draw=40).limit(wanted)
        truth = true_mean_time(chart, limit.value, long, INTERVAL)
        held += limit.low <= truth <= limit.high
        inverse.append(wanted / truth)
    assert held >= 54
    assert np.mean(inverse) < 1.3, "the limits are too low on average"


def cusum(scores, interval=1.0, **more):
    return FalseAlarms(make_chart("cusum"), scores, interval, **more)


def test_independent_tables_do_not_hold_for_dependent_scores():
    wanted, limit = 1000.0, 5.757350  # Page's integral equation, solved for independent normal scores
    assert cusum(dependent(1, 200, 500, 0.8)).at(limit).high < wanted / 5.0
    found = cusum(dependent(1, 200, 500, 0.0)).at(limit)
    assert found.low < wanted < found.high
    # records of 5 scores are joined: this limit needs some 10
    joined = cusum(dependent(2, 4000, 5, 0.0)).at(4.171316)
    assert joined.mean_time == pytest.approx(200.0, rel=0.15)


def test_a_mean_time_beyond_the_data_is_refused_with_what_is_needed():
    healthy = cusum(dependent(3, 100, 360, 0.5))
    with pytest.raises(
        NotStatedError, match="24 h between false alarms needs 24 h of healthy scores, not 10 h"
    ) as refusal:
        healthy.limit(24 * 3600.0)
    assert refusal.value.records_needed == 240
    limit = healthy.limit(10 * 3600.0)
    assert limit.n_alarm == pytest.approx(1.0, abs=0.2)
    assert limit.low < 36000.0 < limit.high


def test_without_an_alarm_the_mean_time_has_a_lower_end_alone_and_missing_scores_take_no_time():
    scores = dependent(4, 50, 100, 0.5)
    scores[:, :20] = np.nan
    found = cusum(scores, 0.5).at(1e6)
    assert found.mean_time == found.high == np.inf
    assert found.duration == 2000.0
    assert found.low == pytest.approx(2000.0 / 3.689, rel=1e-3)
    with pytest.raises(NotStatedError, match="no healthy record has a time series of scores"):
        cusum(np.full((6, 10), np.nan))


def test_alarms_of_one_record_count_as_one():
    scores = np.zeros((40, 100))
    scores[7] = 3.0
    found = cusum(scores, n_draw=400).at(10.0)
    assert found.n_alarm == pytest.approx(25.0)
    assert found.high / found.low > 100.0


def test_every_group_comes_equally_often_and_whole():
    streams = np.arange(14.0).reshape(7, 2)
    groups = cusum(streams, groups=["a", "a", "", "b", "", "b", "c"]).groups
    drawn = streams[np.hstack(list(operations(groups, 7)))].reshape(1, -1)
    assert sorted(len(each) for each in groups) == [1, 1, 1, 2, 2]
    np.testing.assert_array_equal(np.bincount(drawn[0].astype(int)), 7)
    np.testing.assert_array_equal(drawn[0, 1::2] - drawn[0, ::2], 1.0)
    assert (drawn[0, np.flatnonzero(drawn[0] == 1.0) + 1] == 2.0).all()
    with pytest.raises(NotStatedError, match="5 independent healthy records, not 2"):
        cusum(np.ones((10, 3)), groups=["a"] * 5 + ["b"] * 5)


def test_a_statistic_that_is_zero_nearly_always_has_no_limit_for_a_short_time():
    healthy = FalseAlarms(make_chart("cusum", {"shift": 8.0}), dependent(0, 60, 100, 0.5), INTERVAL)
    with pytest.raises(NotStatedError, match="no limit above 0 has so many false alarms"):
        healthy.limit(1.0)


def test_delays_by_hand_where_each_stream_has_its_own_onset():
    scores = np.array(
        [
            [0, 0, 0, 9, 0, 9],  # found at once
            [0, 9, 0, 0, 0, 9],  # a false alarm, then found
            [9, 9, 0, 0, 0, 0],  # false alarms alone: not found
            [0, 0, 0, np.nan, np.nan, np.nan],  # nothing to find it by
            [9, 0, 0, 9, 0, 9],  # found by its first score
        ]
    )
    shewhart = make_chart("ewma", {"weight": 1, "direction": "rising"})
    found = delays(shewhart, 5.0, scores, 0.1 * np.arange(6), [0.3, 0.3, 0.3, 0.3, 0.0])
    np.testing.assert_allclose(found.values, [0.0, 0.2, np.inf, np.inf, 0.0], atol=1e-12)
    np.testing.assert_array_equal(found.n_early, [0, 1, 2, 0, 0])
    assert found.not_measurable == 1
    # the chart starts anew after a false alarm: what it had summed before the onset is gone
    scores = np.array([[3.0, 0, 0.9, 0.9, 0.9, 0.9, 0.9]])
    found = delays(make_chart("cusum"), 1.5, scores, np.arange(7.0), 2.0)
    assert (found.n_early.tolist(), found.values.tolist()) == ([1], [3.0])


def test_mean_delays_are_run_lengths():
    draw = np.random.default_rng(1)
    found = delays(make_chart("cusum"), 5.0, 1.0 + draw.standard_normal((4000, 100)), np.arange(100.0), 0.0)
    error = found.values.std() / np.sqrt(4000)
    assert abs(found.values.mean() + 1.0 - 10.37597) < 3.0 * error


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_intervals_of_quantiles_cover_and_leaks_that_are_not_found_make_quantiles_infinite(share):
    truth, held = -np.log(1.0 - share), 0
    for seed in range(200):
        drawn = Delays(np.random.default_rng(seed).exponential(size=60), np.zeros(60, dtype=int), 0)
        quantile = drawn.quantile(share)
        assert quantile.low <= quantile.value <= quantile.high
        held += quantile.low <= truth <= quantile.high
    assert 182 <= held <= 200
    some = Delays(np.array([1.0] * 6 + [np.inf] * 4), np.zeros(10, dtype=int), 0)
    assert some.quantile(0.5).value == 1.0
    assert some.quantile(0.5).high == some.quantile(0.9).value == np.inf


def dependent(seed, n_stream, n_time, memory, between=0.0):
    """Scores of unit variance with correlation `memory` from one to the next, and offsets of streams."""
    draw = np.random.default_rng(seed)
    scores = autoregressive(draw, (n_stream, n_time), memory)
    return scores + between * draw.standard_normal((n_stream, 1))


def true_mean_time(chart, limit, scores, interval):
    return scores.size * interval / max(int(np.sum(chart.follow(scores.reshape(1, -1), limit) >= limit)), 0.3)
