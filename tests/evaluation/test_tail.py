"""The tail model extrapolates where it holds, and refuses where it does not."""

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import genpareto

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import (
    GeneralisedPareto,
    anderson_darling,
    fit_generalised_pareto,
    tail_threshold,
)
from tests.evaluation.repeats import holds_at_least


@pytest.mark.parametrize("shape", [-0.3, -1e-12, 0.0, 0.4])
def test_survival_is_that_of_scipy_and_inverts(shape):
    model = GeneralisedPareto(np.array(shape), np.array(2.0))
    excess = np.array([0.0, 0.1, 1.0, 5.0])
    np.testing.assert_allclose(model.survival(excess), genpareto.sf(excess, shape, scale=2.0), rtol=1e-6)
    np.testing.assert_allclose(model.excess(model.survival(excess)), excess, rtol=1e-6, atol=1e-9)


def test_nothing_lies_beyond_the_end_of_a_short_tail():
    assert GeneralisedPareto(np.array(-0.5), np.array(1.0)).survival(np.array([3.0])).tolist() == [0.0]


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
    true = GeneralisedPareto(np.full(2000, 0.1), np.ones(2000))
    statistics = anderson_darling(true, rows)
    assert abs(np.mean(statistics > 2.492) - 0.05) < 0.015  # Stephens (1974), 5 % of a known distribution


@pytest.mark.parametrize(
    ("draw", "survival"),
    [
        (lambda g: g.exponential(size=2000), lambda x: np.exp(-x)),
        (lambda g: g.normal(size=2000), lambda x: ndtr(-x)),
    ],
)
def test_the_true_rate_lies_in_the_interval_and_good_tails_are_seldom_refused(draw, survival):
    generator = np.random.default_rng(3)
    inside = stated = 0
    for seed in range(60):
        try:
            threshold = tail_threshold(draw(generator), 1e-3, seed=seed)
        except NotStatedError:
            continue
        stated += 1
        inside += threshold.interval[0] <= survival(threshold.high) <= threshold.interval[1]
    assert holds_at_least(stated, 60, 0.9)
    assert holds_at_least(inside, stated, 0.9)


def test_tails_that_the_model_does_not_describe_are_refused():
    generator = np.random.default_rng(4)
    two_peaks = np.append(generator.normal(size=1900), generator.normal(8.0, 0.1, size=100))
    with pytest.raises(NotStatedError, match="Anderson–Darling"):
        tail_threshold(two_peaks, 1e-3)
    with pytest.raises(NotStatedError, match="equal scores"):
        tail_threshold(np.round(generator.exponential(size=1000)), 1e-3)
    with pytest.raises(NotStatedError, match="equal scores"):
        tail_threshold(np.ones(1000), 1e-3)
    with pytest.raises(NotStatedError, match="infinite"):
        tail_threshold(np.append(generator.normal(size=1000), np.inf), 1e-3)


def test_rates_out_of_reach_are_refused():
    scores = np.random.default_rng(5).exponential(size=1000)
    with pytest.raises(NotStatedError, match="500 healthy records, not 400") as refused:
        tail_threshold(scores[:400], 1e-3)
    assert refused.value.records_needed == 500
    with pytest.raises(NotStatedError, match="10000"):
        tail_threshold(scores, 1e-5)
    with pytest.raises(NotStatedError, match="tolerance limit"):
        tail_threshold(scores, 0.2)


def test_both_tails_share_the_rate_and_falling_mirrors_rising():
    scores = np.random.default_rng(6).laplace(size=3000)
    both = tail_threshold(scores, 2e-3, direction=Direction.BOTH)
    rising = tail_threshold(scores, 1e-3)
    falling = tail_threshold(-scores, 1e-3, direction=Direction.FALLING)
    assert both.high == rising.high
    assert falling.low == -rising.high
    assert both.low == tail_threshold(scores, 1e-3, direction=Direction.FALLING).low
    assert both.interval[1] > rising.interval[1]


def test_scores_in_another_unit_give_the_threshold_in_it():
    scores = np.append(np.random.default_rng(7).exponential(size=1000), np.nan)
    one, thousand = tail_threshold(scores, 1e-3), tail_threshold(1000.0 * scores + 5.0, 1e-3)
    assert thousand.high == pytest.approx(1000.0 * one.high + 5.0)
    assert one.not_measurable == 1
