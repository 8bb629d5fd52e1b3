"""Scores that learn from both kinds, against two Gaussians with one covariance."""

import math

import numpy as np
import pytest
from scipy.special import ndtr

from hydrofdi.detectors.registry import make_score
from hydrofdi.evaluation.roc import area_under_curve
from tests.detectors.scores.populations import gaussians

COVARIANCE = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.3], [0.0, 0.3, 2.0]])
DISTANCE = np.array([0.5, -0.3, 0.2])
WEIGHTS = np.linalg.solve(COVARIANCE, DISTANCE)
"""Of the best line, and of the true log-odds: Anderson, Multivariate Analysis (2003), 6.4."""


def weights_of(model, n_feature):
    """The weights of a linear score, from its values alone."""
    return model.score(np.eye(n_feature)) - model.score(np.zeros((1, n_feature)))


@pytest.mark.parametrize("name", ["lda", "logistic"])
def test_weights_are_those_of_the_true_log_odds(name):
    draw = np.random.default_rng(1)
    found = weights_of(make_score(name).fit(*gaussians(draw, 50_000, COVARIANCE, DISTANCE)), 3)
    np.testing.assert_allclose(found, WEIGHTS, atol=0.05)


@pytest.mark.parametrize("name", ["lda", "logistic"])
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


@pytest.mark.parametrize("name", ["lda", "logistic"])
def test_records_that_lie_wholly_apart_and_features_given_twice_are_no_obstacle(name):
    draw = np.random.default_rng(6)
    is_faulty = np.arange(40) >= 20
    values = draw.normal(size=(40, 5)) + 50.0 * is_faulty[:, None]
    scores = make_score(name).fit(np.hstack([values, values]), is_faulty).score(np.hstack([values, values]))
    assert scores[is_faulty].min() > scores[~is_faulty].max()


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


@pytest.mark.parametrize("name", ["lda", "logistic"])
def test_the_area_on_fresh_records_is_that_of_the_distance(name):
    draw = np.random.default_rng(2)
    model = make_score(name).fit(*gaussians(draw, 20_000, COVARIANCE, DISTANCE))
    values, is_faulty = gaussians(draw, 20_000, COVARIANCE, DISTANCE)
    scores = model.score(values)
    area = area_under_curve(scores[~is_faulty], scores[is_faulty], confidence=0.999)
    d_prime = math.sqrt(DISTANCE @ WEIGHTS)
    assert area.low <= ndtr(d_prime / math.sqrt(2.0)) <= area.high
