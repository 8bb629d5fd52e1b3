"""Rates of alarms, and areas under the ROC curve."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr, ndtri
from scipy.stats import binomtest, t

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import (
    alarm_rate,
    area_under_curve,
    clopper_pearson,
    grouped_area,
    healthy_against_healthy,
    left_out_outcomes,
    placements,
    roc_curve,
)
from hydrofdi.evaluation.threshold import quantile_threshold, tolerance_threshold
from tests.evaluation.repeats import holds_at_least

SCORES = st.lists(st.integers(-5, 5).map(float) | st.just(math.inf), min_size=1, max_size=30)


@given(SCORES, SCORES)
def test_the_area_is_the_share_of_pairs_won(healthy, faulty):
    wins = sum((x < y) + 0.5 * (x == y) for x in healthy for y in faulty) / (len(healthy) * len(faulty))
    area = area_under_curve(healthy, faulty)
    assert area.value == wins, "to the last bit, as halves of pairs are whole numbers"
    assert area.low <= area.value + 1e-9
    assert area.value <= area.high + 1e-9
    assert area_under_curve(faulty, healthy).value == pytest.approx(1.0 - wins)
    false_alarm_rate, detection_rate = roc_curve(healthy, faulty)
    assert np.trapezoid(detection_rate, false_alarm_rate) == pytest.approx(wins)


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
    low, n, m = apart.low, apart.n_healthy, apart.n_faulty  # Newcombe's method 5 at its own limit
    pairs = (1.0 - low) / (2.0 - low) + low / (1.0 + low)
    variance = low * (1.0 - low) * (1.0 + ((n + m) / 2.0 - 1.0) * pairs) / (n * m)
    assert 1.0 - low == pytest.approx(ndtri(0.975) * math.sqrt(variance))
    mirrored = area_under_curve(2.0 + draw.random(20), draw.random(20))
    assert mirrored.high == pytest.approx(1.0 - apart.low)
    held = sum(
        area_under_curve(draw.normal(size=15), draw.normal(3.0, size=15)).low <= ndtr(3.0 / math.sqrt(2.0))
        for _ in range(1000)
    )
    assert held >= 950
    equal = area_under_curve(np.ones(30), np.append(np.ones(30), np.nan))
    assert equal.low < equal.value < equal.high
    assert (equal.value, equal.n_faulty) == (0.5, 30)


RULE = partial(quantile_threshold, false_alarm_rate=0.05)


def test_the_exact_interval_is_that_of_scipy():
    for count, total in ((0, 1), (1, 1), (0, 300), (3, 300), (29, 29), (150, 300)):
        expected = binomtest(count, total).proportion_ci(0.9, method="exact")
        np.testing.assert_allclose(clopper_pearson(count, total, 0.9), expected, rtol=1e-9)


def test_records_without_a_score_are_counted_apart():
    rate = alarm_rate([1.0, 0.0, np.nan, np.nan])
    assert (rate.count, rate.total, rate.not_measurable, rate.value) == (1, 2, 2, 0.5)
    nothing = alarm_rate([np.nan])
    assert (nothing.total, nothing.low, nothing.high, nothing.not_measurable) == (0, 0.0, 1.0, 1)
    assert math.isnan(nothing.value)


def test_the_effective_number_of_records_of_a_worked_example():
    outcomes, groups = np.repeat([1.0, 0.0, 1.0, 0.0], [4, 6, 2, 8]), np.repeat(list("ab"), 10)
    rate = alarm_rate(outcomes, groups=list(groups))
    variance = 2.0 * (1.0**2 + 1.0**2) / 20**2  # G/(G - 1) Σ (hits - p size)² / n²
    effective = 0.3 * 0.7 / variance * (t.ppf(0.975, 19) / t.ppf(0.975, 1)) ** 2
    assert (rate.low, rate.high) == pytest.approx(clopper_pearson(0.3 * effective, effective))
    silent = alarm_rate(np.zeros(20), groups=list(groups))
    assert silent.high == clopper_pearson(0, 2)[1], "groups that agree count as one record each"


@pytest.mark.parametrize(
    ("n_group", "share", "size", "least"), [(10, 0.1, 5, 0.93), (30, 0.1, 5, 0.93), (30, 0.01, 4, 0.8)]
)
def test_clustered_intervals_hold_where_plain_ones_do_not_and_less_so_for_rare_bursts(
    n_group, share, size, least
):
    draw, held, plainly = np.random.default_rng(3), 0, 0
    groups = [str(number) for number in np.repeat(np.arange(n_group), 40)]
    for _ in range(300):
        shares = np.repeat(draw.beta(share * size, (1.0 - share) * size, size=n_group), 40)
        outcomes = draw.random(shares.size) < shares
        rate, plain = alarm_rate(outcomes, groups=groups), alarm_rate(outcomes)
        held += rate.low <= share <= rate.high
        plainly += plain.low <= share <= plain.high
    assert holds_at_least(held, 300, least)
    assert plainly < 0.75 * 300


def test_a_group_is_judged_by_the_others_alone():
    healthy = np.concatenate((np.random.default_rng(4).normal(size=200), np.full(20, 50.0)))
    groups = ["a"] * 100 + ["b"] * 100 + ["strange"] * 20
    outcomes = left_out_outcomes(healthy, groups, RULE)
    assert outcomes[200:].mean() == 1.0
    assert outcomes[:100].mean() < 0.1
    with pytest.raises(NotStatedError, match="two groups"):
        left_out_outcomes(healthy, ["a"] * 220, RULE)


def test_healthy_groups_are_set_against_each_other():
    draw = np.random.default_rng(6)
    healthy = np.concatenate(
        (draw.normal(size=300), draw.normal(size=300), draw.normal(3.0, size=40), [np.nan])
    )
    groups = ["a"] * 300 + ["b"] * 300 + ["warm"] * 40 + ["lost"]
    pairs = {(p.fit_group, p.test_group): p for p in healthy_against_healthy(healthy, groups, RULE)}
    assert len(pairs) == 6
    assert pairs["a", "b"].area.low < 0.5 < pairs["a", "b"].area.high
    assert pairs["a", "b"].area.value == pytest.approx(1.0 - pairs["b", "a"].area.value)
    assert pairs["a", "warm"].area.low > 0.9
    assert pairs["a", "warm"].rate.low > 0.5
    strict = healthy_against_healthy(healthy, groups, partial(tolerance_threshold, false_alarm_rate=0.01))
    refused = next(pair for pair in strict if pair.fit_group == "warm")
    assert refused.rate is None
    assert "299" in refused.refusal


def test_groups_that_are_apart_count_as_one_record_each():
    healthy, faulty = np.repeat(np.arange(5.0), 3), np.repeat([9.0], 3)
    area = grouped_area(healthy, faulty, [*"aaabbbcccdddeee"], ["f"] * 3)
    alone = area_under_curve(np.arange(5.0), [9.0])
    assert (area.value, area.low, area.high) == (1.0, alone.low, 1.0)
    assert 0.0 < area.low < 0.9


def test_grouped_areas_hold_the_truth_where_groups_shift_the_scores():
    draw = np.random.default_rng(9)
    names, places = [str(i) for i in np.repeat(np.arange(20), 10)], np.repeat(np.arange(20), 10)
    truth, held, plainly = 0.691462, 0, 0  # Φ(1/√4): unit shifts of independent groups beside unit noise
    for _ in range(200):
        healthy = draw.normal(draw.normal(size=20)[places])
        faulty = draw.normal(draw.normal(1.0, size=20)[places])
        area = grouped_area(healthy, faulty, names, [f"faulty {name}" for name in names])
        plain = area_under_curve(healthy, faulty)
        held += area.low <= truth <= area.high
        plainly += plain.low <= truth <= plain.high
    assert holds_at_least(held, 200, 0.93)
    assert plainly < 0.75 * 200


def test_many_groups_need_no_drawing():
    draw = np.random.default_rng(12)
    names, places = [str(i) for i in np.repeat(np.arange(60), 5)], np.repeat(np.arange(60), 5)
    shifts = draw.normal(size=60)
    healthy, faulty = draw.normal(shifts[places]), draw.normal(shifts[places] + 1.0)
    drawn = grouped_area(healthy, faulty, names, names, many=61)
    summed = grouped_area([*healthy, np.nan], faulty, [*names, "0"], names)
    assert (summed.low, summed.high) == pytest.approx((drawn.low, drawn.high), abs=0.012)
    assert (summed.value, summed.n_healthy) == (drawn.value, 300)
    each = [str(i) for i in range(600)]
    alone, delong = grouped_area(healthy, faulty, each[:300], each[300:]), area_under_curve(healthy, faulty)
    assert (alone.low, alone.high) == pytest.approx((delong.low, delong.high), abs=5e-4)
    apart = grouped_area(healthy, healthy + 99.0, names, names)
    assert (apart.low, apart.high) == (area_under_curve(healthy, healthy + 99.0).low, 1.0)
    with pytest.raises(NotStatedError, match="5 groups, not 4"):
        grouped_area(healthy[:20], faulty[:20], names[:20], names[:20])
