"""Scores of healthy records alone, against what is known of them."""

import numpy as np
import pytest
from scipy.stats import chi2, kstest
from sklearn.covariance import LedoitWolf, ShrunkCovariance

from hydrofdi.detectors.rules import make_score, score_names
from hydrofdi.detectors.scores.contract import cross_fitted_scores, healthy_scale
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import area_under_curve
from tests.detectors.scores.populations import Population, gaussians


def healthy_scores(score, fit, records):
    return score.fit(fit, np.zeros(len(fit), dtype=bool)).score(records)


@pytest.mark.parametrize("shrinkage", [0.0, 0.2])
def test_the_distance_is_that_of_the_textbook_with_the_stated_shrinkage_of_standardised_features(shrinkage):
    draw = np.random.default_rng(3)
    fit, records = draw.normal(size=(30, 10)) * np.logspace(0, 6, 10), draw.normal(size=(20, 10))
    low, centre, high = np.quantile(fit, [0.25, 0.5, 0.75], axis=0)
    scale = (high - low) / 1.3489795003921634
    reference = ShrunkCovariance(shrinkage=shrinkage).fit((fit - centre) / scale)
    found = healthy_scores(make_score("mahalanobis", {"shrinkage": shrinkage}), fit, records)
    np.testing.assert_allclose(found, reference.mahalanobis((records - centre) / scale), rtol=1e-9)


def test_the_shrinkage_that_fit_records_choose_leaves_small_faults_across_nuisances():
    """Four nuisances rule 20 features, so that healthy records hardly vary along the fault."""
    population = Population(n_feature=20, noise=0.03, seed=4)
    fit, healthy, faulty = (population.records(300, severity) for severity in (0.0, 0.0, 0.03))
    areas = []
    for options in ({}, {"shrinkage": LedoitWolf().fit(fit).shrinkage_}):
        score = make_score("mahalanobis", options)
        areas.append(
            area_under_curve(*(healthy_scores(score, fit, part) for part in (healthy, faulty))).value
        )
    assert areas[0] > areas[1] + 0.1


def test_distances_of_fresh_gaussian_records_follow_chi_squared():
    draw = np.random.default_rng(4)
    mixed = draw.normal(size=(5, 5))
    fit, fresh = draw.normal(size=(40_000, 5)) @ mixed, draw.normal(size=(2_000, 5)) @ mixed
    assert kstest(healthy_scores(make_score("mahalanobis"), fit, fresh), chi2(5).cdf).pvalue > 1e-3


def test_one_class_sees_a_hole_among_healthy_records_and_the_distance_does_not():
    draw = np.random.default_rng(7)
    angles, noise = draw.uniform(0.0, 2.0 * np.pi, (2, 300)), 0.05 * draw.normal(size=(2, 300, 2))
    fit, healthy = np.stack([np.cos(angles), np.sin(angles)], axis=2) + noise
    parts = healthy, 0.1 * draw.normal(size=(300, 2))
    one_class, distance = make_score("one_class", {"width": 0.3}), make_score("mahalanobis")
    assert area_under_curve(*(healthy_scores(one_class, fit, part) for part in parts)).low > 0.95
    assert area_under_curve(*(healthy_scores(distance, fit, part) for part in parts)).high < 0.05


@pytest.mark.parametrize("outside", [0.02, 0.3])
def test_at_most_the_stated_share_of_fit_records_lies_outside(outside):
    fit = Population(seed=8).records(1000)
    scores = healthy_scores(make_score("one_class", {"outside": outside}), fit, fit)
    assert 0.3 * outside < np.mean(scores > 1e-2) <= outside


def test_a_healthy_scale_leaves_out_what_is_missing():
    assert healthy_scale(np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]]))[0] == 3.0
    for scores in (np.ones(10), np.arange(4.0)):
        with pytest.raises(NotStatedError):
            healthy_scale(scores)


SPREAD = 0.05


def records(draw, n_record, fault=0.0, nuisance=(-1.0, 1.0), proxy_fault=0.0):
    """A feature that a nuisance moves by 10 spreads and more, beside a proxy of the nuisance."""
    stiffness = draw.uniform(*nuisance, n_record)
    feature = 3.0 + 2.0 * stiffness - stiffness**2 + fault + SPREAD * draw.normal(size=n_record)
    return np.stack([feature, 500.0 + 100.0 * stiffness + proxy_fault], axis=1)


def fitted(values):
    return make_score("compensated").fit(values, np.zeros(len(values), bool))


def test_a_nuisance_goes_and_the_effect_of_the_fault_stays():
    draw = np.random.default_rng(1)
    model = fitted(records(draw, 500))
    healthy, faulty = model.score(records(draw, 500)), model.score(records(draw, 500, fault=-0.4))
    assert np.std(healthy) == pytest.approx(SPREAD, rel=0.1)
    assert np.mean(healthy) == pytest.approx(0.0, abs=0.01)
    assert np.mean(faulty) == pytest.approx(-0.4, abs=0.01)
    raw = area_under_curve(records(draw, 500, fault=-0.4)[:, 0], records(draw, 500)[:, 0]).value
    assert area_under_curve(faulty, healthy).value > 0.99 > 0.7 > raw


def test_a_fault_that_moves_the_proxy_is_in_part_compensated():
    draw = np.random.default_rng(2)
    model = fitted(records(draw, 500))
    still, moved = (records(draw, 500, 0.4, (-0.1, 0.1), by) for by in (0.0, 10.0))
    assert np.mean(model.score(still)) == pytest.approx(0.4, abs=0.02)
    assert np.mean(model.score(moved)) == pytest.approx(0.2, abs=0.02)


def test_beyond_the_range_of_the_fit_a_proxy_counts_as_at_its_end():
    draw = np.random.default_rng(3)
    fit = records(draw, 500)
    model, last = fitted(fit), fit[np.argmax(fit[:, 1])]
    beyond = last + np.array([[0.0, 0.0], [0.0, 50.0], [0.0, 1e6], [0.7, 1e6]])
    scores = model.score(beyond)
    np.testing.assert_array_equal(scores[1:3], scores[0])
    assert scores[3] == pytest.approx(scores[0] + 0.7)


def test_the_score_has_the_unit_of_the_feature():
    draw = np.random.default_rng(4)
    fit, fresh = records(draw, 200), records(draw, 20)
    expected = fitted(fit).score(fresh)
    for scale in (np.array([1e6, 1.0]), np.array([1e6, -1e-9])):
        np.testing.assert_allclose(fitted(fit * scale).score(fresh * scale), 1e6 * expected, rtol=1e-6)


COVARIANCE = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.3], [0.0, 0.3, 2.0]])
DISTANCE = np.array([0.5, -0.3, 0.2])
WEIGHTS = np.linalg.solve(COVARIANCE, DISTANCE)
"""Of the best line, and of the true log-odds: Anderson, Multivariate Analysis (2003), 6.4."""


def weights_of(model, n_feature):
    """The weights of a linear score, from its values alone."""
    return model.score(np.eye(n_feature)) - model.score(np.zeros((1, n_feature)))


every_score = pytest.mark.parametrize("name", score_names())
learners = pytest.mark.parametrize("name", ["lda", pytest.param("logistic", marks=pytest.mark.long)])


@learners
def test_weights_are_those_of_the_true_log_odds(name):
    draw = np.random.default_rng(1)
    found = weights_of(make_score(name).fit(*gaussians(draw, 50_000, COVARIANCE, DISTANCE)), 3)
    np.testing.assert_allclose(found, WEIGHTS, atol=0.05)


@learners
def test_a_fault_that_only_shows_across_a_nuisance_is_found_whatever_the_nuisance(name):
    draw = np.random.default_rng(3)

    def records(n_record, fault, nuisance=0.0):
        load = nuisance + draw.normal(size=(n_record, 1))
        return load * [1.0, 2.0] + 0.05 * draw.normal(size=(n_record, 2)) + fault * np.array([0.3, 0.0])

    values = np.vstack([records(300, 0.0), records(300, 1.0)])
    model = make_score(name).fit(values, np.arange(600) >= 300)
    healthy, faulty, shifted = (model.score(records(300, *case)) for case in ((0.0,), (1.0,), (0.0, 5.0)))
    assert area_under_curve(healthy, faulty).low > 0.95
    assert np.mean(shifted > np.quantile(healthy, 0.99)) < 0.3


def test_lda_weighs_both_kinds_alike_however_many_records_they_have():
    draw = np.random.default_rng(8)
    spreads, apart = np.array([[1.0, 1.0], [1.0, 3.0]]), np.array([1.0, 1.0])
    healthy, faulty = (
        draw.normal(size=(n, 2)) * each for n, each in zip((50_000, 5_000), spreads, strict=True)
    )
    is_faulty = np.arange(55_000) >= 50_000
    model = make_score("lda").fit(np.vstack([healthy, faulty + apart]), is_faulty)
    np.testing.assert_allclose(weights_of(model, 2), apart / np.mean(spreads**2, axis=0), atol=0.05)
    assert model.score([apart / 2.0])[0] == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("is_fit", [np.arange(120) >= 0, np.arange(120) % 7 > 0], ids=["all fit", "six of 7"])
@every_score
def test_no_record_is_scored_by_a_model_that_saw_its_group(name, is_fit):
    values, is_faulty = Population(seed=3).labelled(60, 60, 1.0)
    day = np.arange(120) % 6
    rows, groups, taught = day == 2, [f"day {number}" for number in day], is_fit & (day != 2)
    expected = make_score(name).fit(values[taught], is_faulty[taught]).score(values[rows])
    np.testing.assert_array_equal(
        cross_fitted_scores(make_score(name), values, is_faulty, groups, is_fit=is_fit)[rows], expected
    )


def test_records_that_are_no_fit_records_are_scored_by_a_model_of_all_and_teach_nothing():
    values, is_faulty = Population(seed=4).labelled(60, 60, 1.0)
    is_fit, lda = np.arange(120) % 3 > 0, make_score("lda")
    scores = cross_fitted_scores(lda, values, is_faulty, is_fit=is_fit)
    model = lda.fit(values[is_fit], is_faulty[is_fit])
    np.testing.assert_array_equal(scores[~is_fit], model.score(values[~is_fit]))
    wild = np.where(is_fit[:, None], values, 1e3 * values)
    others = cross_fitted_scores(lda, wild, is_faulty, is_fit=is_fit)
    np.testing.assert_array_equal(others[is_fit], scores[is_fit])


def test_records_without_a_group_are_groups_by_themselves_and_every_fold_has_both_kinds():
    lda, (values, is_faulty) = make_score("lda"), Population(seed=5).labelled(30, 30, 1.0)
    for groups, n_fold in (([""] * 60, 60), ([f"{row:03}" for row in range(60)], 10)):
        np.testing.assert_array_equal(
            cross_fitted_scores(lda, values, is_faulty, groups, n_fold=n_fold),
            cross_fitted_scores(lda, values, is_faulty, n_fold=n_fold),
        )
    values, is_faulty = Population(seed=7).labelled(95, 6, 5.0)
    for seed in range(20):
        assert np.isfinite(cross_fitted_scores(lda, values, is_faulty, n_fold=6, seed=seed)).all()
