"""Thresholds: quantiles, tolerance limits and tails."""

import math

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import beta, binom, genpareto

from hydrofdi.errors import HydrofdiError, NotStatedError
from hydrofdi.evaluation.rates import learned_direction
from hydrofdi.evaluation.scores import Direction, suspicion
from hydrofdi.evaluation.threshold import (
    GeneralisedPareto,
    anderson_darling,
    fit_generalised_pareto,
    quantile_threshold,
    records_needed,
    tail_threshold,
    tolerance_threshold,
)
from tests.evaluation.repeats import holds_at_least, holds_in


def test_the_number_of_records_is_the_published_one_the_smallest_by_the_binomial_distribution():
    for rank, needed in {1: 299, 2: 473, 3: 628, 5: 913, 10: 1568, 20: 2784}.items():
        assert records_needed(0.01, 0.95, rank) == needed
    for rate, confidence, rank in ((0.05, 0.9, 1), (0.1, 0.99, 4), (0.001, 0.95, 1), (0.5, 0.5, 1)):
        n = records_needed(rate, confidence, rank)
        assert binom.sf(rank - 1, n, rate) >= confidence > binom.sf(rank - 1, n - 1, rate)


def test_too_few_records_are_refused_with_the_number_that_would_do():
    with pytest.raises(NotStatedError, match="299 healthy records, not 298") as refused:
        tolerance_threshold(np.arange(298.0), 0.01)
    assert refused.value.records_needed == 299
    assert isinstance(refused.value, HydrofdiError)
    assert tolerance_threshold(np.arange(299.0), 0.01).high == 298.0
    with pytest.raises(NotStatedError, match="473"):
        tolerance_threshold(np.arange(400.0), 0.01, direction=Direction.BOTH)
    with pytest.raises(NotStatedError, match="99 healthy records, not 98"):
        quantile_threshold(np.arange(98.0), 0.01)
    assert quantile_threshold(np.arange(99.0), 0.01).high == 98.0


def test_the_quantile_keeps_its_rate_on_average_and_its_interval_in_repeats():
    threshold = quantile_threshold(np.arange(1000.0), 0.01, confidence=0.9)
    assert threshold.high == 990.0, "the tenth largest"
    np.testing.assert_allclose(threshold.interval, beta(10, 991).ppf([0.05, 0.95]))
    draw = np.random.default_rng(11)
    thresholds = [quantile_threshold(scores, 0.01) for scores in draw.normal(size=(1000, 300))]
    rates = ndtr([-threshold.high for threshold in thresholds])
    assert abs(rates.mean() - 3 / 301) < 4 * rates.std() / math.sqrt(1000)
    inside = sum(t.interval[0] <= rate <= t.interval[1] for t, rate in zip(thresholds, rates, strict=True))
    assert holds_in(inside, 1000, 0.95)


@pytest.mark.parametrize("direction", Direction)
@pytest.mark.parametrize("n", [473, 700])
def test_the_tolerance_limit_keeps_its_confidence(direction, n):
    draw = np.random.default_rng(13)
    kept = 0
    for scores in draw.exponential(size=(1000, n)):
        threshold = tolerance_threshold(scores, 0.01, direction=direction)
        rate = math.exp(-threshold.high) - math.expm1(-max(threshold.low, 0.0))
        kept += rate <= 0.01
    sides = direction.n_side
    rank = max(k for k in range(sides, 30, sides) if beta.cdf(0.01, k, n + 1 - k) >= 0.95)
    assert holds_in(kept, 1000, beta.cdf(0.01, rank, n + 1 - rank))
    np.testing.assert_allclose(threshold.interval, (0.0, beta(rank, n + 1 - rank).ppf(0.95)))


def test_both_directions_leave_half_on_each_side_and_the_others_mirror_each_other():
    threshold = quantile_threshold(np.arange(199.0), 0.01, direction=Direction.BOTH)
    assert (threshold.low, threshold.high) == (0.0, 198.0)
    assert threshold.outcomes([-1.0, 0.0, 100.0, 198.0, 199.0]).tolist() == [1, 0, 0, 0, 1]
    scores = np.random.default_rng(14).normal(size=500)
    rising = quantile_threshold(scores, 0.02)
    falling = quantile_threshold(-scores, 0.02, direction=Direction.FALLING)
    assert falling.low == -rising.high
    assert falling.high == -rising.low == math.inf


def test_equal_and_infinite_scores_have_thresholds_and_those_that_are_missing_are_counted_apart():
    threshold = tolerance_threshold(np.append(np.arange(500.0), [np.nan] * 7), 0.01)
    assert (threshold.n_healthy, threshold.not_measurable) == (500, 7)
    assert np.isnan(threshold.outcomes([np.nan, 1.0])).tolist() == [True, False]
    assert quantile_threshold(np.ones(200), 0.01).outcomes([1.0, 1.1]).tolist() == [0, 1]
    infinite = quantile_threshold(np.append(np.zeros(150), np.full(50, np.inf)), 0.01)
    assert infinite.outcomes([1e300, np.inf]).tolist() == [0, 0]


def test_a_direction_is_learned_only_where_fit_records_settle_it_and_suspicion_grows_along_it():
    draw = np.random.default_rng(17)
    healthy = draw.normal(size=100)
    assert learned_direction(healthy, healthy + 2.0) is Direction.RISING
    assert learned_direction(healthy, healthy - 2.0) is Direction.FALLING
    assert learned_direction(healthy, 4.0 * draw.normal(size=100)) is Direction.BOTH
    assert suspicion([1.0, 2.0, 4.0], Direction.BOTH, 2.0).tolist() == [1.0, 0.0, 2.0]
    assert suspicion([1.0, 2.0], Direction.FALLING).tolist() == [-1.0, -2.0]


@pytest.mark.parametrize("shape", [-0.3, -1e-12, 0.0, 0.4])
def test_survival_is_that_of_scipy_and_inverts(shape):
    model = GeneralisedPareto(np.array(shape), np.array(2.0))
    excess = np.array([0.0, 0.1, 1.0, 5.0])
    np.testing.assert_allclose(model.survival(excess), genpareto.sf(excess, shape, scale=2.0), rtol=1e-6)
    np.testing.assert_allclose(model.excess(model.survival(excess)), excess, rtol=1e-6, atol=1e-9)
    assert shape > -0.2 or model.survival(np.array([7.0])).tolist() == [0.0], "a short tail has an end"


def test_fits_lie_around_the_truth_and_are_as_good_as_maximum_likelihood():
    rows = np.sort(genpareto.rvs(0.2, scale=3.0, size=(300, 400), random_state=1), axis=-1)
    fitted = fit_generalised_pareto(rows)
    assert abs(np.median(fitted.shape) - 0.2) < 0.03
    assert abs(np.median(fitted.scale) - 3.0) < 0.1
    assert fitted.shape.std() < 1.15 * (1.0 + 0.2) / 20.0  # Smith (1987): (1 + ξ)/√n by maximum likelihood
    shape, _, scale = genpareto.fit(rows[0], floc=0.0)
    assert abs(fitted.shape[0] - shape) < 0.03
    assert abs(fitted.scale[0] - scale) < 0.1


def test_anderson_darling_of_the_true_distribution_has_its_known_distribution():
    rows = np.sort(genpareto.rvs(0.1, size=(2000, 100), random_state=2), axis=-1)
    statistics = anderson_darling(GeneralisedPareto(np.full(2000, 0.1), np.ones(2000)), rows)
    assert abs(np.mean(statistics > 2.492) - 0.05) < 0.015  # Stephens (1974), 5 % of a known distribution


@pytest.mark.parametrize("is_normal", [False, True])
def test_the_true_rate_lies_in_the_interval_and_good_tails_are_seldom_refused(is_normal):
    generator = np.random.default_rng(3)
    inside = stated = 0
    for seed in range(60):
        scores = generator.normal(size=2000) if is_normal else generator.exponential(size=2000)
        try:
            threshold = tail_threshold(scores, 1e-3, seed=seed)
        except NotStatedError:
            continue
        stated += 1
        rate = ndtr(-threshold.high) if is_normal else np.exp(-threshold.high)
        inside += threshold.interval[0] <= rate <= threshold.interval[1]
    assert holds_at_least(stated, 60, 0.9)
    assert holds_at_least(inside, stated, 0.9)


def test_tails_that_the_model_does_not_describe_and_rates_out_of_reach_are_refused():
    generator, scores = np.random.default_rng(4), np.random.default_rng(5).exponential(size=1000)
    two_peaks = np.append(generator.normal(size=1900), generator.normal(8.0, 0.1, size=100))
    for own, rate, why in (
        (two_peaks, 1e-3, "Anderson–Darling"),
        (np.round(scores), 1e-3, "equal scores"),
        (np.append(scores, np.inf), 1e-3, "infinite"),
        (scores, 1e-5, "10000"),
        (scores, 0.2, "tolerance limit"),
        (scores[:400], 1e-3, "500 healthy records, not 400"),
    ):
        with pytest.raises(NotStatedError, match=why):
            tail_threshold(own, rate)
    tail_threshold(scores[:500], 1e-3)


def test_both_tails_share_the_rate_and_falling_mirrors_rising_in_any_unit():
    scores = np.random.default_rng(6).laplace(size=3000)
    both = tail_threshold(scores, 2e-3, direction=Direction.BOTH)
    rising = tail_threshold(scores, 1e-3)
    falling = tail_threshold(-scores, 1e-3, direction=Direction.FALLING)
    assert both.high == rising.high
    assert falling.low == -rising.high
    assert both.low == tail_threshold(scores, 1e-3, direction=Direction.FALLING).low
    assert both.interval[1] > rising.interval[1]
    assert tail_threshold(1000.0 * scores + 5.0, 1e-3).high == pytest.approx(1000.0 * rising.high + 5.0)
