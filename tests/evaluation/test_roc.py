"""Areas and curves against what is known of them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr

from hydrofdi.evaluation.roc import area_under_curve, placements, roc_curve
from tests.evaluation.repeats import holds_in

SCORES = st.lists(st.integers(-5, 5).map(float) | st.just(math.inf), min_size=1, max_size=30)


@pytest.mark.parametrize("distance", [0.0, 0.5, 1.0, 2.5])
def test_two_unit_gaussians_have_their_known_area(distance):
    draw = np.random.default_rng(1)
    area = area_under_curve(draw.normal(size=40_000), draw.normal(distance, size=40_000), confidence=0.999)
    assert area.low <= ndtr(distance / math.sqrt(2.0)) <= area.high
    assert area.high - area.low < 0.014


@given(SCORES, SCORES)
def test_the_area_is_the_share_of_pairs_won(healthy, faulty):
    wins = sum((x < y) + 0.5 * (x == y) for x in healthy for y in faulty) / (len(healthy) * len(faulty))
    area = area_under_curve(healthy, faulty)
    assert area.value == pytest.approx(wins)
    assert area.low <= area.value + 1e-9
    assert area.value <= area.high + 1e-9
    assert area_under_curve(faulty, healthy).value == pytest.approx(1.0 - wins)
    curve = roc_curve(healthy, faulty)
    assert np.trapezoid(curve.detection_rate, curve.false_alarm_rate) == pytest.approx(wins)


def test_the_variance_of_delong_is_that_of_the_kernel():
    draw = np.random.default_rng(3)
    healthy, faulty = draw.normal(size=20).round(1), draw.normal(1.0, size=30).round(1)
    kernel = (healthy[:, None] < faulty) + 0.5 * (healthy[:, None] == faulty)
    of_healthy, of_faulty = placements(healthy, faulty)
    np.testing.assert_allclose(of_healthy, kernel.mean(axis=1))
    np.testing.assert_allclose(of_faulty, kernel.mean(axis=0))


@pytest.mark.parametrize("distance", [0.0, 1.0, 2.0])
def test_intervals_of_areas_hold_the_truth_in_95_of_100_repeats(distance):
    draw, truth = np.random.default_rng(4), ndtr(distance / math.sqrt(2.0))
    areas = [area_under_curve(draw.normal(size=80), draw.normal(distance, size=60)) for _ in range(1000)]
    held = sum(area.low <= truth <= area.high for area in areas)
    assert abs(held - 950) <= 25


def test_intervals_reach_no_certainty_where_all_scores_are_apart():
    draw = np.random.default_rng(5)
    apart = area_under_curve(draw.random(20), 2.0 + draw.random(20))
    assert (apart.value, apart.high) == (1.0, 1.0)
    assert 0.8 < apart.low < 0.99
    mirrored = area_under_curve(2.0 + draw.random(20), draw.random(20))
    assert mirrored.high == pytest.approx(1.0 - apart.low)
    more = area_under_curve(draw.random(200), 2.0 + draw.random(200))
    assert apart.low < more.low < 1.0
    held = sum(
        area_under_curve(draw.normal(size=15), draw.normal(3.0, size=15)).low <= ndtr(3.0 / math.sqrt(2.0))
        for _ in range(1000)
    )
    assert held >= 950


def test_shuffled_labels_give_one_half():
    draw = np.random.default_rng(6)
    scores, inside = np.append(draw.normal(size=100), draw.normal(2.0, size=100)), 0
    for _ in range(1000):
        draw.shuffle(scores)
        area = area_under_curve(scores[:100], scores[100:])
        inside += area.low <= 0.5 <= area.high
    assert holds_in(inside, 1000, 0.95)


def test_monotone_transforms_change_nothing():
    draw = np.random.default_rng(7)
    healthy, faulty = draw.normal(size=90), draw.normal(1.0, size=80)
    assert area_under_curve(healthy, faulty) == area_under_curve(np.exp(healthy), np.exp(faulty))
    plain, bent = roc_curve(healthy, faulty), roc_curve(healthy**3, faulty**3)
    np.testing.assert_array_equal(plain.detection_rate, bent.detection_rate)
    assert plain.partial_area(0.1) == bent.partial_area(0.1)


def test_a_curve_rises_from_corner_to_corner_and_its_thresholds_give_its_rates():
    draw = np.random.default_rng(8)
    healthy, faulty = draw.normal(size=60).round(1), np.append(draw.normal(1.0, size=50).round(1), np.nan)
    curve = roc_curve(healthy, faulty)
    assert (curve.false_alarm_rate[0], curve.detection_rate[0]) == (0.0, 0.0)
    assert (curve.false_alarm_rate[-1], curve.detection_rate[-1]) == (1.0, 1.0)
    assert np.all(np.diff(curve.false_alarm_rate) >= 0.0)
    assert np.all(np.diff(curve.detection_rate) >= 0.0)
    place = curve.threshold.size // 2
    assert curve.false_alarm_rate[place] == pytest.approx(np.mean(healthy >= curve.threshold[place]))
    assert curve.miss_rate[place] == pytest.approx(np.mean(faulty[:-1] < curve.threshold[place]))
    assert curve.not_measurable == 1


def test_partial_areas_run_from_chance_to_perfect():
    draw = np.random.default_rng(10)
    assert roc_curve(draw.random(50), 2.0 + draw.random(50)).partial_area(0.1) == pytest.approx(1.0)
    assert roc_curve(np.ones(50), np.ones(50)).partial_area(0.1) == pytest.approx(0.5)
    assert roc_curve(np.ones(1), np.full(1, 2.0)).partial_area(0.01) == pytest.approx(1.0)


def test_single_equal_and_infinite_scores_have_areas():
    assert area_under_curve([0.0], [1.0]).value == 1.0
    equal = area_under_curve(np.ones(30), np.ones(30))
    assert equal.value == 0.5
    assert equal.low < 0.5 < equal.high
    assert area_under_curve([-np.inf, 0.0], [np.inf, 0.0, np.nan]).not_measurable == 1


def test_areas_are_those_of_scikit_learn():
    metrics = pytest.importorskip("sklearn.metrics")
    draw = np.random.default_rng(11)
    healthy, faulty = draw.normal(size=300).round(1), draw.normal(1.0, size=200).round(1)
    labels, scores = np.repeat([0, 1], [300, 200]), np.append(healthy, faulty)
    assert area_under_curve(healthy, faulty).value == pytest.approx(metrics.roc_auc_score(labels, scores))
    curve = roc_curve(healthy, faulty)
    for limit in (0.01, 0.1, 0.5):
        expected = metrics.roc_auc_score(labels, scores, max_fpr=limit)
        assert curve.partial_area(limit) == pytest.approx(expected)
    rates = metrics.roc_curve(labels, scores, drop_intermediate=False)
    np.testing.assert_allclose(curve.false_alarm_rate, rates[0])
    np.testing.assert_allclose(curve.detection_rate, rates[1])
