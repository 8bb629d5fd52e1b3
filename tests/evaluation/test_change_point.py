"""Trends: false ones are rare, onset and limit lie in their intervals, and what is not known stays open."""

import numpy as np
import pytest

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation import change_point
from hydrofdi.evaluation.scores import Estimate
from tests.evaluation import wear
from tests.evaluation.repeats import holds_at_least, holds_in

N_DAY = 40
DAYS = np.arange(float(N_DAY))


@pytest.fixture(scope="module")
def model():
    return change_point.ChangePointModel(DAYS)


@pytest.mark.parametrize(
    "noise",
    [
        "independent", "AR(1) 0.95", *(pytest.param(noise, marks=pytest.mark.long)
        for noise in ("AR(1) 0.5", "AR(1) 0.8 and 30 % white")),
    ],
)  # fmt: skip
def test_a_healthy_machine_rarely_has_a_trend(model, noise):
    scores = (wear.spread(np.random.default_rng(seed), N_DAY, *wear.NOISES[noise]) for seed in range(50))
    found = sum(model.p_value(each, 199) <= 0.05 for each in scores)
    assert found <= 7  # 1 in 1000 if the rate is 5 %


@pytest.mark.parametrize("law", wear.LAWS)
def test_onset_and_limit_lie_in_their_intervals(model, law):
    n_repeat, n_onset, n_limit = 60, 0, 0
    for seed in range(n_repeat):
        truth = wear.worn(seed, N_DAY, law, "AR(1) 0.5")
        draws = model.draws(truth.scores, 1000)
        onset, reached = (
            Estimate.of(each, 0.9, draws.spacing) for each in (draws.onset, draws.reached(truth.limit))
        )
        n_onset += onset.low <= truth.onset <= onset.high
        n_limit += reached.low <= truth.reached <= reached.high
    assert holds_at_least(n_onset, n_repeat, 0.9)
    assert holds_at_least(n_limit, n_repeat, 0.9)


def test_a_jump_in_a_gap_may_be_anywhere_between_the_points_around_it():
    """Sixty days without a tenth of the days and a week about the jump, and with an outlier."""
    n_repeat, n_day, n_onset, n_found, widths = 20, 60, 0, 0, []
    for seed in range(n_repeat):
        random, truth = np.random.default_rng([seed, 1]), wear.worn(seed, n_day, "sudden", "independent")
        days, first = np.arange(n_day), int(truth.onset) - random.integers(0, 7)
        kept = ((days < first) | (days >= first + 7)) & (random.random(n_day) > 0.1)
        scores = truth.scores.copy()
        scores[random.choice(np.flatnonzero(kept))] += 40.0
        kept[kept] = change_point.inliers(scores[kept])
        model = change_point.ChangePointModel(days[kept].astype(float))
        if model.p_value(scores[kept], 199) > 0.01:
            continue
        draws = model.draws(scores[kept], 1000)
        onset = Estimate.of(draws.onset, 0.95, draws.spacing)
        n_found += 1
        n_onset += onset.low <= truth.onset <= onset.high
        widths.append(onset.high - onset.low)
    assert n_found > 0.9 * n_repeat
    assert holds_at_least(n_onset, n_found, 0.95)
    assert np.median(widths) <= 9.0, "no wider than the gap, and days that are missing beside it"


def test_onsets_are_evenly_spread_also_over_gaps():
    gap = np.concatenate([np.arange(10.0), np.arange(17.0, 30.0)])
    model = change_point.ChangePointModel(gap)
    sudden = model.onset[model.law == 0]
    np.testing.assert_allclose(np.diff(sudden), 1.0)
    assert (sudden[0], sudden[-1]) == (change_point.AFTER - 0.5, 29.0 - change_point.AFTER + 0.5)
    whole = change_point.ChangePointModel(np.arange(400.0)).onset
    assert whole.size < 1000, "not one for each of many points"


def test_intervals_are_no_wider_than_they_need_to_be(model):
    covered = 0
    for seed in range(100):
        truth = wear.worn(seed, N_DAY, "sudden", "AR(1) 0.5")
        growth = truth.limit / (0.5 if np.isfinite(truth.reached) else 1.5)
        found = Estimate.of(model.draws(truth.scores, 1000).growth, 0.8)
        covered += found.low <= growth <= found.high
    assert holds_in(covered, 100, 0.8)


@pytest.mark.parametrize("law", wear.LAWS)
def test_a_clear_growth_is_found(model, law):
    scores = wear.worn(1, N_DAY, law, "independent").scores
    assert model.p_value(scores, 199) <= 0.01


def test_statements_do_not_depend_on_the_unit_or_the_zero_of_the_score(model):
    scores = wear.worn(3, N_DAY, "linear", "AR(1) 0.5").scores
    other = 1e-6 * (scores + 7.0)
    assert model.p_value(other, 199) == model.p_value(scores, 199)
    np.testing.assert_allclose(model.draws(other).level, 1e-6 * (model.draws(scores).level + 7.0), rtol=1e-9)
    np.testing.assert_allclose(model.draws(other).onset, model.draws(scores).onset)


def test_the_level_reaches_the_limit_when_it_is_said_to_and_at_the_stated_rate():
    n_law, last = len(change_point.LAWS), 39.0
    ones = np.ones(n_law)
    draws = change_point.Draws(
        DAYS, ones, 3.0 * ones, 20.0 * ones, np.arange(n_law), np.empty((n_law, 0)), ones, 0.5
    )
    at = draws.reached(4.5)
    assert at[0] == np.inf
    for law in range(1, n_law):
        assert draws.levels(at[law : law + 1])[0, law] == pytest.approx(4.5)
        slope = np.diff(draws.levels([last - 1e-6, last + 1e-6])[:, law])[0] / 2e-6
        assert draws.rate[law] == pytest.approx(slope)
    assert np.all(draws.reached(0.5) == -np.inf)
    assert draws.reached(1000.0)[1] == np.inf, "beyond the horizon"


def test_levels_are_one_at_the_last_point_and_zero_before_the_onset():
    laws = np.arange(len(change_point.LAWS))
    shares = change_point.grown(np.array([5.0, 20.0, 39.0]), np.full(laws.size, 20.0), laws, 39.0)
    np.testing.assert_allclose(shares, [[0.0], [0.0], [1.0]] * np.ones(laws.size))


def test_a_covariate_is_taken_out():
    random = np.random.default_rng(2)
    warm = 10.0 * np.sin(DAYS / 12.0) + random.standard_normal(N_DAY)
    scores = 0.5 * warm + 0.3 * random.standard_normal(N_DAY)
    with_warm = change_point.ChangePointModel(DAYS, warm)
    assert with_warm.p_value(scores, 199) > 0.05
    slope = Estimate.of(with_warm.draws(scores, is_changed=False).slopes[:, 0], 0.99)
    assert slope.low < 0.5 < slope.high
    assert slope.high - slope.low < 0.15


def test_single_outliers_are_left_out_and_a_lasting_change_is_not():
    truth = wear.worn(4, N_DAY, "sudden", "independent")
    scores = truth.scores.copy()
    scores[[5, 17, 39]] += [30.0, -25.0, 40.0]
    assert np.flatnonzero(~change_point.inliers(scores)).tolist() == [5, 17, 39]


def test_short_histories_are_refused():
    with pytest.raises(NotStatedError) as refused:
        change_point.ChangePointModel(np.arange(change_point.FEWEST - 1.0))
    assert refused.value.records_needed == change_point.FEWEST


def test_the_evidence_of_a_change_is_its_integral_over_the_growth(model):
    """For changes that differ in law and onset, against that of no change in what the growth leaves."""
    scores = wear.worn(7, N_DAY, "linear", "independent").scores
    growths = np.linspace(-200.0, 200.0, 4001)
    changes = [3, 50, 120, 200]
    columns = change_point.grown(DAYS, model.onset[changes], model.law[changes], DAYS[-1])
    stated = next(model.evidences(scores[:, None]))[1][changes, 0] - np.log(model._prior[changes])
    left = (scores[:, None] - np.multiply.outer(column, growths) for column in columns.T)
    integrals = np.array([np.trapezoid(np.exp(next(model.evidences(each))[0] + 60.0)) for each in left])
    np.testing.assert_allclose(np.diff(stated), np.diff(np.log(integrals)), rtol=1e-6)


def test_the_correlation_of_two_points_depends_on_the_time_between_them():
    time = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 18.0, 19.0, 20.0])
    noise = change_point.ChangePointModel(time).noises[1]
    correlation = noise.cholesky @ noise.cholesky.T
    assert correlation[0, 1] == pytest.approx(0.2)
    assert correlation[8, 9] == pytest.approx(0.2**10)
