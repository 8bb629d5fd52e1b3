"""Two detectors on the same records, and many of them."""

import math

import numpy as np
import pytest
from scipy.stats import binomtest

from hydrofdi.evaluation.auc import area_under_curve
from hydrofdi.evaluation.comparison import compare_alarms, compare_areas
from hydrofdi.evaluation.multiplicity import holm, simultaneous_confidence
from hydrofdi.evaluation.refusal import NotStatedError
from tests.evaluation.repeats import holds_at_least, holds_in


def _pair(draw, n, shifts, correlation):
    covariance = [[1.0, correlation], [correlation, 1.0]]
    return tuple(draw.multivariate_normal(shifts, covariance, size=n).T)


def test_equal_detectors_are_distinguished_as_often_as_the_level_says():
    draw, n_found = np.random.default_rng(1), 0
    for _ in range(1000):
        healthy, faulty = _pair(draw, 60, (0.0, 0.0), 0.8), _pair(draw, 60, (1.0, 1.0), 0.8)
        n_found += compare_areas(healthy, faulty).p_value < 0.05
    assert holds_in(n_found, 1000, 0.05)


def test_the_interval_of_the_difference_holds_it():
    draw, held = np.random.default_rng(2), 0
    truth = 0.5 * (math.erf(1.5 / 2.0) - math.erf(1.0 / 2.0))
    for _ in range(500):
        healthy, faulty = _pair(draw, 80, (0.0, 0.0), 0.6), _pair(draw, 80, (1.5, 1.0), 0.6)
        difference = compare_areas(healthy, faulty)
        held += difference.low <= truth <= difference.high
    assert abs(held / 500 - 0.95) < 0.03


def test_pairing_narrows_the_difference_of_like_detectors():
    draw = np.random.default_rng(3)
    healthy, faulty = _pair(draw, 200, (0.0, 0.0), 0.95), _pair(draw, 200, (1.2, 1.0), 0.95)
    paired = compare_areas(healthy, faulty)
    areas = [area_under_curve(h, f) for h, f in zip(healthy, faulty, strict=True)]
    assert paired.value == pytest.approx(areas[0].value - areas[1].value)
    assert paired.high - paired.low < 0.5 * (areas[0].high - areas[0].low)


def test_a_detector_and_itself_do_not_differ():
    scores = np.random.default_rng(4).normal(size=(2, 30))
    itself = compare_areas((scores[0], scores[0]), (scores[1], scores[1]))
    assert (itself.value, itself.low, itself.high) == (0.0, 0.0, 0.0)
    assert math.isnan(itself.p_value)


def test_records_that_lack_a_score_leave_the_pair_and_are_counted():
    first, second = np.array([1.0, np.nan, 0.0, 1.0]), np.array([0.0, 1.0, 0.0, np.nan])
    difference = compare_alarms(first, second)
    assert (difference.n_record, difference.not_measurable, difference.value) == (2, 2, 0.5)
    with pytest.raises(NotStatedError, match="both detectors"):
        compare_alarms([np.nan], [1.0])
    with pytest.raises(NotStatedError, match="two records of each kind"):
        compare_areas(([1.0], [1.0]), ([1.0, 2.0], [1.0, 2.0]))


@pytest.mark.parametrize(("more", "fewer"), [(0, 0), (1, 0), (8, 1), (3, 3), (40, 20)])
def test_the_exact_test_of_mcnemar_is_the_binomial_one(more, fewer):
    first = np.repeat([1.0, 0.0, 1.0], [more, fewer, 10])
    second = np.repeat([0.0, 1.0, 1.0], [more, fewer, 10])
    expected = binomtest(more, more + fewer).pvalue if more + fewer else 1.0
    difference = compare_alarms(first, second)
    assert difference.p_value == pytest.approx(expected)
    assert difference.low < difference.high
    assert difference.value == pytest.approx((more - fewer) / (more + fewer + 10))


def test_the_interval_of_paired_rates_holds_their_difference():
    draw, held = np.random.default_rng(5), 0
    for _ in range(1000):
        level = draw.random(100)
        difference = compare_alarms(level < 0.3, np.where(draw.random(100) < 0.8, level < 0.3, level < 0.1))
        held += difference.low <= 0.04 <= difference.high
    assert holds_at_least(held, 1000, 0.94)


def test_the_interval_of_paired_rates_of_a_published_table():
    """Airway reactivity of 21 children: Fagerland et al., Statistics in Medicine 33 (2014) 2850."""
    first, second = (
        np.repeat([1.0, 1.0, 0.0, 0.0], [1, 1, 7, 12]),
        np.repeat([1.0, 0.0, 1.0, 0.0], [1, 1, 7, 12]),
    )
    difference = compare_alarms(first, second)
    assert (difference.low, difference.high) == pytest.approx((-0.517, -0.026), abs=5e-4)


def test_the_interval_of_paired_rates_turns_with_the_detectors():
    first, second = np.repeat([1.0, 0.0, 1.0], [9, 3, 10]), np.repeat([0.0, 1.0, 1.0], [9, 3, 10])
    one, other = compare_alarms(first, second), compare_alarms(second, first)
    assert (one.low, one.high) == pytest.approx((-other.high, -other.low))
    assert (one.low > 0.0) == (one.p_value < 0.01)
    assert compare_alarms(np.ones(5), np.zeros(5)).high == 1.0


def test_the_test_of_mcnemar_is_that_of_statsmodels():
    tables = pytest.importorskip("statsmodels.stats.contingency_tables")
    first, second = np.repeat([1.0, 0.0, 1.0], [9, 3, 10]), np.repeat([0.0, 1.0, 1.0], [9, 3, 10])
    expected = tables.mcnemar([[10, 9], [3, 0]], exact=True).pvalue
    assert compare_alarms(first, second).p_value == pytest.approx(expected)


def test_corrected_p_values_of_a_worked_example():
    corrected = holm([0.01, 0.04, 0.03, 0.005])
    np.testing.assert_allclose(corrected.p_values, [0.03, 0.06, 0.06, 0.02])
    assert corrected.n_tried == 4


def test_what_was_tried_and_not_reported_counts():
    assert holm([0.01], n_tried=50).p_values.tolist() == [0.5]
    with pytest.raises(ValueError, match="2 p-values of 1 tests"):
        holm([0.1, 0.2], n_tried=1)
    unknown = holm([np.nan, 0.01])
    assert unknown.p_values[1] == 0.02
    assert np.isnan(unknown.p_values[0])


def test_any_false_finding_is_as_rare_as_one_test_allows():
    p_values = np.random.default_rng(6).random((2000, 20))
    found = sum(holm(row).p_values.min() < 0.05 for row in p_values)
    assert holds_in(found, 2000, 1.0 - (1.0 - 0.05 / 20) ** 20)


def test_intervals_of_many_hold_together():
    assert simultaneous_confidence(0.95, 1) == 0.95
    assert simultaneous_confidence(0.95, 50) == pytest.approx(0.999)
