"""Scores of healthy records alone, against what is known of them."""

import numpy as np
import pytest
from scipy.stats import chi2, kstest
from sklearn.covariance import LedoitWolf, ShrunkCovariance

from hydrofdi.detectors.registry import make_score
from hydrofdi.detectors.scores.features import healthy_scale
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.roc import area_under_curve
from tests.detectors.scores.populations import Population


def healthy_scores(score, fit, records):
    return score.fit(fit, np.zeros(len(fit), dtype=bool)).score(records)


def test_without_shrinkage_the_distance_is_that_of_the_textbook():
    draw = np.random.default_rng(2)
    fit, records = draw.normal(size=(100, 3)), draw.normal(size=(20, 3))
    apart = records - fit.mean(axis=0)
    inverse = np.linalg.inv(np.cov(fit, rowvar=False, bias=True))
    expected = np.einsum("ij,jk,ik->i", apart, inverse, apart)
    found = healthy_scores(make_score("mahalanobis", {"shrinkage": 0.0}), fit, records)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_stated_shrinkage_is_that_of_standardised_features():
    draw = np.random.default_rng(3)
    fit, records = draw.normal(size=(30, 10)) * np.logspace(0, 6, 10), draw.normal(size=(20, 10))
    low, centre, high = np.quantile(fit, [0.25, 0.5, 0.75], axis=0)
    scale = (high - low) / 1.3489795003921634
    reference = ShrunkCovariance(shrinkage=0.2).fit((fit - centre) / scale)
    expected = reference.mahalanobis((records - centre) / scale)
    found = healthy_scores(make_score("mahalanobis", {"shrinkage": 0.2}), fit, records)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def area_of_a_fault(options, n_fit):
    """Of one across four nuisances that rule 20 features, so that healthy records hardly vary along it."""
    population = Population(n_feature=20, noise=0.03, seed=4)
    fit, healthy, faulty = population.records(n_fit), population.records(300), population.records(300, 0.03)
    score = make_score("mahalanobis", options)
    return area_under_curve(*(healthy_scores(score, fit, part) for part in (healthy, faulty))).value


def test_the_shrinkage_that_fit_records_choose_leaves_small_faults_across_nuisances():
    population = Population(n_feature=20, noise=0.03, seed=4)
    of_ledoit_and_wolf = LedoitWolf().fit(population.records(300)).shrinkage_
    assert area_of_a_fault({}, 300) > area_of_a_fault({"shrinkage": of_ledoit_and_wolf}, 300) + 0.1


def test_distances_of_fresh_gaussian_records_follow_chi_squared():
    draw = np.random.default_rng(4)
    mixed = draw.normal(size=(5, 5))
    fit, fresh = draw.normal(size=(40_000, 5)) @ mixed, draw.normal(size=(2_000, 5)) @ mixed
    assert kstest(healthy_scores(make_score("mahalanobis"), fit, fresh), chi2(5).cdf).pvalue > 1e-3


def ring(draw, n_record, radius):
    angle = draw.uniform(0.0, 2.0 * np.pi, n_record)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return radius * around + 0.05 * draw.normal(size=(n_record, 2))


def test_one_class_sees_a_hole_among_healthy_records_and_the_distance_does_not():
    draw = np.random.default_rng(7)
    fit, healthy, faulty = ring(draw, 300, 1.0), ring(draw, 300, 1.0), 0.1 * draw.normal(size=(300, 2))
    one_class = make_score("one_class", {"width": 0.3})
    inside = area_under_curve(*(healthy_scores(one_class, fit, part) for part in (healthy, faulty)))
    assert inside.low > 0.95
    distance = area_under_curve(
        *(healthy_scores(make_score("mahalanobis"), fit, part) for part in (healthy, faulty))
    )
    assert distance.high < 0.05


@pytest.mark.parametrize("outside", [0.02, 0.1, 0.3])
def test_at_most_the_stated_share_of_fit_records_lies_outside(outside):
    fit = Population(seed=8).records(1000)
    scores = healthy_scores(make_score("one_class", {"outside": outside}), fit, fit)
    assert 0.3 * outside < np.mean(scores > 1e-2) <= outside


def test_without_shrinkage_no_invertible_transform_changes_the_distance():
    draw = np.random.default_rng(1)
    fit, records = draw.normal(size=(200, 4)), 3.0 * draw.normal(size=(50, 4))
    score = make_score("mahalanobis", {"shrinkage": 0.0})
    expected = healthy_scores(score, fit, records)
    for _ in range(5):
        matrix, offset = draw.normal(size=(4, 4)), draw.normal(size=4)
        moved = healthy_scores(score, fit @ matrix + offset, records @ matrix + offset)
        np.testing.assert_allclose(moved, expected, rtol=1e-6)


def test_a_healthy_scale_leaves_out_what_is_missing():
    assert healthy_scale(np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]]))[0] == 3.0
    for scores in (np.ones(10), np.arange(4.0)):
        with pytest.raises(NotStatedError):
            healthy_scale(scores)
