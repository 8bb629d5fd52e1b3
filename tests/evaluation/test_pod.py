"""Curves of the probability of detection: what is recovered, what is bounded, what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.pod import (
    Response,
    lack_of_fit,
    last_shown,
    log_likelihood,
    probability_of_detection,
    relative_spread,
    smallest_detectable,
    tally,
)
from hydrofdi.evaluation.rates import clopper_pearson
from tests.evaluation.repeats import holds_at_least, holds_in

LEVELS = np.logspace(-2.0, 0.0, 9)
SEVERITY = np.repeat(LEVELS, 100)


def true_severity(probability, location, spread, floor):
    return 10.0 ** (location + spread * ndtri((probability - floor) / (1.0 - floor)))


def hits(draw, severity, location=-1.2, spread=0.15, floor=0.01):
    rise = ndtr((np.log10(severity) - location) / spread)
    return (draw.random(severity.size) < floor + (1.0 - floor) * rise).astype(float)


@pytest.mark.parametrize("floor", [0.0, 0.05])
def test_a_known_curve_is_recovered(floor):
    severity = 10.0 ** np.random.default_rng(1).uniform(-2.0, 0.0, size=20_000)
    outcomes = hits(np.random.default_rng(2), severity, -1.2, 0.15, floor)
    curve = probability_of_detection(severity, outcomes, false_alarm_rate=floor)
    assert (-curve.intercept / curve.slope, 1.0 / curve.slope) == pytest.approx((-1.2, 0.15), abs=0.01)
    for probability in (0.5, 0.9):
        found = smallest_detectable(curve, probability=probability, confidence=None).value
        assert found == pytest.approx(true_severity(probability, -1.2, 0.15, floor), rel=0.03)
        assert curve.probability(found) == pytest.approx(probability)


@pytest.mark.parametrize("floor", [0.0, 0.02])
def test_the_fit_is_the_maximum_that_a_general_search_finds(floor):
    draw = np.random.default_rng(3)
    for spread in (0.1, 0.4):
        outcomes = hits(draw, SEVERITY, -1.1, spread, floor)
        curve = probability_of_detection(SEVERITY, outcomes, false_alarm_rate=floor)
        places = np.log10(curve.tally.severity)

        def negative(x, counted=curve.tally, places=places):
            return -log_likelihood(x[0] + x[1] * places, counted, floor)

        best = minimize(negative, [3.0, 2.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-11})
        assert curve.log_likelihood == pytest.approx(-best.fun, abs=1e-6)
        assert (curve.intercept, curve.slope) == pytest.approx(tuple(best.x), rel=1e-3)
    assert np.isneginf(log_likelihood(np.full(LEVELS.size, -1.5e154), curve.tally, floor)) == (floor == 0.0)


def covered(repeats, n, floor, spread, probability, seed):
    """How often the bound lies at or above the truth."""
    draw, severity, count = np.random.default_rng(seed), np.repeat(LEVELS, n), 0
    truth = true_severity(probability, -1.2, spread, floor)
    for _ in range(repeats):
        outcomes = hits(draw, severity, -1.2, spread, floor)
        curve = probability_of_detection(severity, outcomes, false_alarm_rate=floor)
        if curve.is_step:  # as in studies: the levels are tested one by one
            counted = tally(severity, outcomes)
            pairs = zip(counted.hits, counted.total, strict=True)
            shown = np.array([clopper_pearson(hit, of, 0.9)[0] for hit, of in pairs]) >= probability
            bound = last_shown(counted.severity, shown, probability, 0.95)
        else:
            bound = smallest_detectable(curve, probability=probability)
        count += bound.place == "above" or bound.severity >= truth
    return count


def test_q90_95_covers_in_95_of_100_repeats():
    assert holds_in(covered(150, 100, 0.01, 0.2, 0.9, seed=5), 150, 0.95)


@pytest.mark.long
@pytest.mark.parametrize("floor", [0.0, 0.01])
@pytest.mark.parametrize("probability", [0.5, 0.9])
def test_bounds_cover_in_95_plus_or_minus_2_of_100_repeats(floor, probability):
    assert abs(covered(1500, 250, floor, 0.2, probability, seed=7) / 1500 - 0.95) < 0.02


@pytest.mark.long
@pytest.mark.parametrize("spread", [0.06, 0.15, 0.3])
def test_with_20_records_a_level_bounds_still_cover_in_90_of_100_repeats(spread):
    assert holds_at_least(covered(600, 20, 0.01, spread, 0.9, seed=23), 600, 0.92)


@pytest.mark.parametrize("floor", [0.0, 0.05])
def test_bounds_are_those_of_all_rising_curves_that_are_likely_enough(floor):
    outcomes = hits(np.random.default_rng(21), SEVERITY, -1.1, 0.25, floor)
    curve = probability_of_detection(SEVERITY, outcomes, false_alarm_rate=floor)
    places, around = np.log10(curve.tally.severity), np.linspace(0.4, 1.8, 200)
    intercepts, slopes = np.meshgrid(around * curve.intercept, around * curve.slope)
    rates = floor + (1.0 - floor) * ndtr(intercepts[..., None] + slopes[..., None] * places)
    likelihood = np.sum(curve.tally.hits * np.log(rates) + curve.tally.misses * np.log1p(-rates), axis=-1)
    likely = 2.0 * (curve.log_likelihood - likelihood) <= 2.7055
    largest = 10.0 ** np.max((curve.quantile_of_rise(0.9) - intercepts[likely]) / slopes[likely])
    assert smallest_detectable(curve).severity == pytest.approx(largest, rel=0.02)


def test_nothing_is_extrapolated():
    draw = np.random.default_rng(10)
    weak = probability_of_detection(SEVERITY, hits(draw, SEVERITY, location=0.3, spread=0.3))
    assert smallest_detectable(weak, confidence=None).place == "above"
    bound = smallest_detectable(weak)
    assert (bound.place, bound.severity, bound.value) == ("above", 1.0, None)
    strong = smallest_detectable(
        probability_of_detection(SEVERITY, hits(draw, SEVERITY, location=-3.5, spread=0.5))
    )
    assert (strong.place, strong.severity) == ("below", pytest.approx(0.01))


@pytest.mark.parametrize("axis", ["log", "linear"])
@pytest.mark.parametrize("floor", [0.0, 0.01, 0.485])
def test_detection_that_does_not_rise_with_severity_finds_nothing(floor, axis):
    draw = np.random.default_rng(42)
    seldom, falling = draw.random(900) < 0.01, (draw.random(900) < 0.7) & (SEVERITY < 0.9)
    for outcomes in (seldom, falling):
        curve = probability_of_detection(SEVERITY, outcomes, false_alarm_rate=floor, axis=axis)
        assert smallest_detectable(curve).place == "above"
    assert curve.slope == 0.0


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from([0.01, 0.03, 0.1, 0.5]), st.booleans()), min_size=1, max_size=40),
    st.sampled_from([0.0, 0.01, 0.3]),
)
def test_any_hits_and_misses_are_judged(records, floor):
    severity, outcomes = np.array(records, dtype=float).T
    curve = probability_of_detection(severity, outcomes, false_alarm_rate=floor)
    assert np.isfinite(curve.log_likelihood)
    rates = curve.probability(np.sort(severity))
    assert np.all((rates >= floor - 1e-12) & (rates <= 1.0))
    assert np.all(np.diff(rates) >= -1e-12)
    if not curve.is_step:
        estimate, bound = (smallest_detectable(curve, confidence=each) for each in (None, 0.95))
        order = ["below", "within", "above"]
        assert order.index(estimate.place) <= order.index(bound.place)
        assert estimate.severity <= bound.severity * (1.0 + 1e-9)
        assert severity.min() <= bound.severity <= severity.max()


def test_a_right_curve_seldom_lacks_fit_and_a_wrong_one_does():
    draw, n_found = np.random.default_rng(16), 0
    for _ in range(200):
        curve = probability_of_detection(SEVERITY, hits(draw, SEVERITY, spread=0.25), false_alarm_rate=0.01)
        n_found += lack_of_fit(curve) < 0.05
    assert holds_in(n_found, 200, 0.05)
    plateau = (draw.random(SEVERITY.size) < np.where(SEVERITY > 0.1, 0.6, 0.01)).astype(float)
    assert lack_of_fit(probability_of_detection(SEVERITY, plateau)) < 1e-6
    assert np.isnan(lack_of_fit(probability_of_detection([0.1, 0.2], [0.0, 1.0])))


def test_measured_severities_are_pooled_without_losing_a_record():
    draw = np.random.default_rng(20)
    severity = 10.0 ** draw.uniform(-2.0, 0.0, size=5000)
    counted = tally(severity, hits(draw, severity))
    assert counted.severity.size <= 1000
    pooled = counted.pooled(10)
    assert (pooled.total.sum(), pooled.hits.sum(), pooled.total.size) == (5000, counted.hits.sum(), 10)
    assert pooled.total.min() > 400
    assert pooled.span[1] == severity.max()


def test_records_without_a_score_or_a_fault_are_no_misses():
    curve = probability_of_detection([0.1, 0.2, 0.2, 0.4], [0.0, 1.0, np.nan, 1.0])
    assert curve.tally.total.sum() == 3
    with pytest.raises(NotStatedError, match="no faulty record"):
        probability_of_detection([0.1], [np.nan])


def test_the_interval_of_a_relative_spread_holds_what_is_true():
    draw = np.random.default_rng(7)
    for n_alone in (49, 200):
        held = 0
        for _ in range(300):
            share = relative_spread(0.4 * draw.standard_normal(n_alone) + 3.0, draw.standard_normal(500))
            held += share.low <= 0.4 <= share.high
        assert held / 300 > 0.9


def test_a_spread_keeps_under_change_of_unit_and_without_failed_records():
    draw = np.random.default_rng(8)
    alone, together = draw.standard_normal(50), 2.0 * draw.standard_normal(400)
    failed = relative_spread(np.append(alone, np.nan), 2.0 + together)
    assert (failed.value, failed.n_record) == (pytest.approx(relative_spread(alone, together).value), 50)
    with pytest.raises(NotStatedError, match="49 records"):
        relative_spread(alone[:48], together)
    with pytest.raises(NotStatedError, match="no spread"):
        relative_spread(alone, np.zeros(400))


def population(centre, seed=8):
    return centre + 0.01 * np.random.default_rng(seed).standard_normal(400)


def response(*medians):
    """A score with these medians at the leaks 0.01, 0.1 and 1."""
    faulty = [population(median, seed) for seed, median in enumerate(medians, 1)]
    return Response(population(0.0, 0), faulty, [0.01, 0.1, 1.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_nuisance_is_told_as_the_leak_that_moves_the_score_as_far_and_never_outside_of_the_tested(sign):
    """Nine in ten healthy scores lie within −2.25 … 1.35 of the middle; 1 is that of 0.01, 2 that of 0.1."""
    rising, centre = response(sign, 2.0 * sign, 3.0 * sign), population(0.0)
    for scores, place, severity in (
        (np.linspace(-2.45, 1.55, 4000), "within", pytest.approx(10.0**-1.65, rel=0.02)),
        (np.linspace(-0.3, 0.3, 400), "below", 0.01),
        (np.linspace(-30.0, 30.0, 400), "above", 1.0),
    ):
        fault = rising.imitated(sign * scores, sign * centre)
        assert (fault.place, fault.severity) == (place, severity)


def test_a_median_that_falls_between_levels_is_made_monotone():
    """1, 3.2, 2.8 are 1, 3, 3: a shift of 2.6 is reached, one of 3.1 is not."""
    found = response(1.0, 3.2, 2.8)
    for half_width, place in ((2.9, "within"), (3.4, "above")):
        scores = np.linspace(-half_width, half_width, 4000)
        assert found.imitated(scores, population(0.0)).place == place
