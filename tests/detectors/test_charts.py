"""Laws of every chart, and what each of them is for."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import chart_names, make_chart

SHORT = {"glr": {"window": 20}, "moving_window": {"window": 8}}


def short(name, **options):
    return make_chart(name, {**SHORT.get(name, {}), **options})


@pytest.fixture
def scores():
    drawn = np.random.default_rng(1).standard_normal((5, 400))
    drawn[1, 100:120] = np.nan
    drawn[2, 200:] += 1.5
    drawn[3, 7] = np.inf
    return drawn


@pytest.mark.parametrize("limit", [np.inf, 2.0])
@pytest.mark.parametrize("size", [1, 7, 133])
@pytest.mark.parametrize("name", chart_names())
def test_a_stream_gives_the_bits_of_the_whole(name, size, limit, scores):
    chart = short(name)
    state, parts = chart.start(5), []
    for first in range(0, 400, size):
        state, statistic = chart.step(state, scores[:, first : first + size], limit)
        parts.append(statistic)
    np.testing.assert_array_equal(np.hstack(parts), chart.follow(scores, limit))


@pytest.mark.parametrize("name", chart_names())
def test_a_stream_does_not_depend_on_its_neighbours(name, scores):
    chart = short(name)
    alone = np.vstack([chart.follow(row[None]) for row in scores])
    np.testing.assert_array_equal(alone, chart.follow(scores))


@pytest.mark.parametrize("name", chart_names())
def test_a_step_leaves_the_old_state_as_it_was(name, scores):
    chart = short(name)
    state, _ = chart.step(chart.start(5), scores[:, :50])
    before = {key: values.copy() for key, values in state.items()}
    chart.step(state, scores[:, 50:])
    assert all(np.array_equal(values, before[key]) for key, values in state.items())


@pytest.mark.parametrize("name", chart_names())
def test_nan_scores_are_passed_over(name):
    chart = short(name)
    scores = np.random.default_rng(2).standard_normal((1, 60))
    holes = np.insert(scores, [10, 10, 40], np.nan, axis=1)
    statistic = chart.follow(holes)
    assert np.isnan(statistic[0, [10, 11, 42]]).all()
    np.testing.assert_array_equal(np.delete(statistic, [10, 11, 42], axis=1), chart.follow(scores))


@pytest.mark.parametrize("name", chart_names())
def test_directions_are_mirrored(name):
    scores = np.random.default_rng(3).standard_normal((2, 200))
    rising, falling = (short(name, direction=direction) for direction in ("rising", "falling"))
    both = short(name)
    np.testing.assert_array_equal(rising.follow(scores), falling.follow(-scores))
    np.testing.assert_array_equal(both.follow(scores), both.follow(-scores))
    largest = np.maximum(rising.follow(scores), falling.follow(scores))
    np.testing.assert_array_equal(both.follow(scores), largest)


@pytest.mark.parametrize("name", chart_names())
def test_a_chart_starts_anew_after_an_alarm(name):
    chart, limit = short(name, direction="rising"), 1.7
    scores = 1.5 + np.random.default_rng(4).standard_normal((1, 100))
    statistic = chart.follow(scores, limit)
    after = int(np.argmax(statistic >= limit)) + 1
    assert np.nanmax(statistic) >= limit
    np.testing.assert_array_equal(statistic[:, after:], chart.follow(scores[:, after:], limit))


@pytest.mark.parametrize("name", chart_names())
def test_an_infinite_score_is_the_largest_and_not_a_hole(name, scores):
    statistic = short(name, direction="rising").follow(scores)
    assert np.isfinite(statistic[3, 10:]).all()
    assert statistic[3, 10] > 1e3


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


@pytest.mark.parametrize("shift", [0.7, 1.5, 3.0])
def test_glr_finds_a_change_of_any_size_soon_after_its_onset(shift):
    scores = np.random.default_rng(7).standard_normal((200, 300))
    scores[:, 200:] += shift
    alarms = make_chart("glr", {"window": 80}).follow(scores, 12.0) >= 12.0
    delays = [np.flatnonzero(row[200:])[0] + 1 for row in alarms if row[200:].any()]
    assert alarms[:, :200].any(axis=1).mean() < 0.1
    assert len(delays) > 190
    assert np.median(delays) == pytest.approx(2.0 * 12.0 / shift**2, rel=0.35, abs=1)


def test_moving_windows_take_mean_and_maximum():
    scores = np.array([[1.0, -5.0, 3.0, 2.0]])
    mean = make_chart("moving_window", {"window": 2})
    most = make_chart("moving_window", {"window": 2, "measure": "maximum", "direction": "rising"})
    np.testing.assert_allclose(mean.follow(scores), [[np.nan, 2.0, 1.0, 2.5]])
    np.testing.assert_allclose(most.follow(scores), [[np.nan, 1.0, 3.0, 3.0]])
