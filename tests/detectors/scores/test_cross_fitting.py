"""Scores by models that saw neither the record nor its group."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import make_score, score_names
from hydrofdi.detectors.scores.cross_fitting import cross_fitted_scores
from hydrofdi.evaluation.roc import area_under_curve
from tests.detectors.scores.populations import Population

every_score = pytest.mark.parametrize("name", score_names())
learners = pytest.mark.parametrize("name", ["lda", "logistic"])


def area(scores, is_faulty):
    return area_under_curve(scores[~is_faulty], scores[is_faulty], confidence=0.999)


@learners
def test_shuffled_labels_tell_nothing_but_where_models_score_what_they_saw(name):
    population, draw, score = Population(n_feature=30, seed=1), np.random.default_rng(1), make_score(name)
    values = population.records(400)
    shuffled = draw.permutation(np.arange(400) >= 200)
    apart = area(cross_fitted_scores(score, values, shuffled), shuffled)
    assert apart.low <= 0.5 <= apart.high
    if name == "lda":
        seen = area(score.fit(values, shuffled).score(values), shuffled)
        assert seen.low > 0.5


@learners
def test_labels_of_groups_tell_nothing_where_whole_groups_are_left_out(name):
    draw, score = np.random.default_rng(2), make_score(name)
    unit = np.repeat(np.arange(40), 10)
    values = (3.0 * draw.normal(size=(40, 15)))[unit] + draw.normal(size=(400, 15))
    is_faulty = draw.permutation(np.arange(40) >= 20)[unit]
    by_record = area(cross_fitted_scores(score, values, is_faulty), is_faulty)
    by_unit = cross_fitted_scores(score, values, is_faulty, [f"unit {number}" for number in unit])
    assert by_record.low > 0.65
    assert 0.2 < area(by_unit, is_faulty).value < 0.65


@every_score
def test_no_record_is_scored_by_a_model_that_saw_its_group(name):
    values, is_faulty = Population(seed=3).labelled(60, 60, 1.0)
    groups = [f"day {record % 6}" for record in range(120)]
    rows = np.arange(120) % 6 == 2
    expected = make_score(name).fit(values[~rows], is_faulty[~rows]).score(values[rows])
    np.testing.assert_array_equal(
        cross_fitted_scores(make_score(name), values, is_faulty, groups)[rows], expected
    )


def test_records_that_are_no_fit_records_are_scored_and_teach_nothing():
    values, is_faulty = Population(seed=4).labelled(60, 60, 1.0)
    is_fit = np.arange(120) % 3 > 0
    scores = cross_fitted_scores(make_score("lda"), values, is_faulty, is_fit=is_fit)
    model = make_score("lda").fit(values[is_fit], is_faulty[is_fit])
    np.testing.assert_array_equal(scores[~is_fit], model.score(values[~is_fit]))
    wild = np.where(is_fit[:, None], values, 1e3 * values)
    others = cross_fitted_scores(make_score("lda"), wild, is_faulty, is_fit=is_fit)
    np.testing.assert_array_equal(others[is_fit], scores[is_fit])


def test_records_without_a_group_are_groups_by_themselves():
    values, is_faulty = Population(seed=5).labelled(30, 30, 1.0)
    expected = cross_fitted_scores(make_score("lda"), values, is_faulty, [f"{row:03}" for row in range(60)])
    np.testing.assert_array_equal(
        cross_fitted_scores(make_score("lda"), values, is_faulty, [""] * 60, n_fold=60),
        cross_fitted_scores(make_score("lda"), values, is_faulty, n_fold=60),
    )
    np.testing.assert_array_equal(cross_fitted_scores(make_score("lda"), values, is_faulty), expected)


def test_every_fold_has_records_of_both_kinds_where_there_are_enough():
    values, is_faulty = Population(seed=7).labelled(95, 6, 5.0)
    for seed in range(20):
        scores = cross_fitted_scores(make_score("lda"), values, is_faulty, n_fold=6, seed=seed)
        assert np.isfinite(scores).all()


def test_records_that_are_no_fit_records_do_not_meet_a_model_of_their_group():
    values, is_faulty = Population(seed=4).labelled(60, 60, 1.0)
    is_fit, day = np.arange(120) % 7 > 0, np.arange(120) % 6
    scores = cross_fitted_scores(
        make_score("lda"), values, is_faulty, [f"day {number}" for number in day], is_fit=is_fit
    )
    taught = is_fit & (day != 2)
    model = make_score("lda").fit(values[taught], is_faulty[taught])
    np.testing.assert_array_equal(scores[day == 2], model.score(values[day == 2]))
