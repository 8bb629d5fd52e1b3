"""Trends: false ones are rare, onset and limit lie in their intervals, and what is not known stays open."""

import numpy as np
import pytest

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.change_point import AFTER, FEWEST, LAWS, ChangePointModel, Draws, grown, inliers
from hydrofdi.evaluation.scores import Estimate
from tests.evaluation.repeats import holds_at_least, holds_in

N_DAY = 40
DAYS = np.arange(float(N_DAY))
GROWTH = {
    "linear": lambda share: share,
    "accelerating, s^2.5": lambda share: share**2.5,
    "accelerating, exp 3s": lambda share: np.expm1(3.0 * share) / np.expm1(3.0),
    "sudden": lambda share: np.where(share > 0.0, 1.0, 0.0),
}
"""Growth over the share of the time from the onset to the end; both that accelerate are none of the model."""


def spread(random, n_day, correlation, white=0.0):
    """Spread from day to day with standard deviation 1, of which a share is not correlated."""
    innovations = random.standard_normal(n_day)
    found = innovations[:1]
    for own in innovations[1:]:
        found = np.append(found, correlation * found[-1] + np.sqrt(1.0 - correlation**2) * own)
    return np.sqrt(1.0 - white) * found + np.sqrt(white) * random.standard_normal(n_day)


def worn(seed, n_day, law, correlation=0.0):
    """Scores of a seal that wears; onset, a limit, and when the level reaches it [days].

    It grows by 6 to 15 deviations from an onset in the middle three fifths on, and reaches the limit in the
    last third of the growth or after the end, also beyond the horizon; a sudden one at once, or never.
    """
    random = np.random.default_rng(seed)
    end, onset, growth = n_day - 1.0, random.uniform(0.2, 0.8) * n_day, random.uniform(6.0, 15.0)

    def level(day):
        return growth * GROWTH[law](np.maximum(day - onset, 0.0) / (end - onset))

    if law == "sudden":
        limit = growth * random.choice([0.5, 1.5])
        reached = onset if limit < growth else np.inf
    else:
        at = random.uniform(end - 0.3 * (end - onset), end + 1.2 * (end - onset))
        limit, reached = level(at), at if at <= 2.0 * end else np.inf
    return level(np.arange(float(n_day))) + spread(random, n_day, correlation), onset, limit, reached


@pytest.fixture(scope="module")
def model():
    return ChangePointModel(DAYS)


@pytest.mark.parametrize(
    "noise", [(0.0,), (0.95,), *(pytest.param(each, marks=pytest.mark.long) for each in ((0.5,), (0.8, 0.3)))]
)
def test_a_healthy_machine_rarely_has_a_trend(model, noise):
    scores = (spread(np.random.default_rng(seed), N_DAY, *noise) for seed in range(50))
    found = sum(model.p_value(each, 199) <= 0.05 for each in scores)
    assert found <= 7  # 1 in 1000 if the rate is 5 %


@pytest.mark.parametrize("law", GROWTH)
def test_a_clear_growth_is_found_and_onset_and_limit_lie_in_their_intervals(model, law):
    assert model.p_value(worn(1, N_DAY, law)[0], 199) <= 0.01
    n_repeat, n_onset, n_limit = 60, 0, 0
    for seed in range(n_repeat):
        scores, onset, limit, reached = worn(seed, N_DAY, law, 0.5)
        draws = model.draws(scores, 1000)
        since, until = (Estimate.of(each, 0.9, draws.spacing) for each in (draws.onset, draws.reached(limit)))
        n_onset += since.low <= onset <= since.high
        n_limit += until.low <= reached <= until.high
    assert holds_at_least(n_onset, n_repeat, 0.9)
    assert holds_at_least(n_limit, n_repeat, 0.9)


def test_onsets_are_evenly_spread_also_over_gaps_and_short_histories_have_none():
    model = ChangePointModel(np.concatenate([np.arange(10.0), np.arange(17.0, 30.0)]))
    sudden = model.onset[model.law == 0]
    np.testing.assert_allclose(np.diff(sudden), 1.0)
    assert (sudden[0], sudden[-1]) == (AFTER - 0.5, 29.0 - AFTER + 0.5)
    assert ChangePointModel(np.arange(400.0)).onset.size < 1000, "not one for each of many points"
    with pytest.raises(NotStatedError) as refused:
        ChangePointModel(np.arange(FEWEST - 1.0))
    assert refused.value.records_needed == FEWEST


def test_intervals_are_no_wider_than_they_need_to_be(model):
    covered = 0
    for seed in range(100):
        scores, _, limit, reached = worn(seed, N_DAY, "sudden", 0.5)
        growth = limit / (0.5 if np.isfinite(reached) else 1.5)
        found = Estimate.of(model.draws(scores, 1000).growth, 0.8)
        covered += found.low <= growth <= found.high
    assert holds_in(covered, 100, 0.8)


def test_statements_do_not_depend_on_the_unit_or_the_zero_of_the_score(model):
    scores = worn(3, N_DAY, "linear", 0.5)[0]
    other = 1e-6 * (scores + 7.0)
    assert model.p_value(other, 199) == model.p_value(scores, 199)
    np.testing.assert_allclose(model.draws(other).level, 1e-6 * (model.draws(scores).level + 7.0), rtol=1e-9)
    np.testing.assert_allclose(model.draws(other).onset, model.draws(scores).onset)


def test_the_level_reaches_the_limit_when_it_is_said_to_and_at_the_stated_rate():
    ones, laws = np.ones(len(LAWS)), np.arange(len(LAWS))
    draws = Draws(DAYS, ones, 3.0 * ones, 20.0 * ones, laws, np.empty((ones.size, 0)), ones, 0.5)
    np.testing.assert_allclose(draws.levels([5.0, 20.0, 39.0]), [[1.0], [1.0], [4.0]] * ones)
    at = draws.reached(4.5)
    assert at[0] == np.inf
    for law in laws[1:]:
        assert draws.levels(at[law : law + 1])[0, law] == pytest.approx(4.5)
        slope = np.diff(draws.levels([39.0 - 1e-6, 39.0 + 1e-6])[:, law])[0] / 2e-6
        assert draws.rate[law] == pytest.approx(slope)
    assert np.all(draws.reached(0.5) == -np.inf)
    assert draws.reached(1000.0)[1] == np.inf, "beyond the horizon"


def test_single_outliers_are_left_out_and_a_lasting_change_is_not():
    scores = worn(4, N_DAY, "sudden")[0]
    scores[[5, 17, 39]] += [30.0, -25.0, 40.0]
    assert np.flatnonzero(~inliers(scores)).tolist() == [5, 17, 39]


def test_the_evidence_of_a_change_is_its_integral_over_the_growth(model):
    """For changes that differ in law and onset, against that of no change in what the growth leaves."""
    scores, growths, changes = (
        worn(7, N_DAY, "linear")[0],
        np.linspace(-200.0, 200.0, 4001),
        [3, 50, 120, 200],
    )
    columns = grown(DAYS, model.onset[changes], model.law[changes], DAYS[-1])
    stated = next(model.evidences(scores[:, None]))[1][changes, 0] - np.log(model._prior[changes])
    left = (scores[:, None] - np.multiply.outer(column, growths) for column in columns.T)
    integrals = np.array([np.trapezoid(np.exp(next(model.evidences(each))[0] + 60.0)) for each in left])
    np.testing.assert_allclose(np.diff(stated), np.diff(np.log(integrals)), rtol=1e-6)


def test_the_correlation_of_two_points_depends_on_the_time_between_them():
    noise = ChangePointModel(np.append(np.arange(9.0), [18.0, 19.0, 20.0])).noises[1]
    correlation = noise.cholesky @ noise.cholesky.T
    assert (correlation[0, 1], correlation[8, 9]) == pytest.approx((0.2, 0.2**10))
