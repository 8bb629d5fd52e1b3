"""What every score keeps to, whatever it learns, and what is known of each."""

import json
import subprocess
import sys

import numpy as np
import pytest
from sklearn.covariance import LedoitWolf, ShrunkCovariance
from sklearn.svm import OneClassSVM

from hydrofdi.detectors.rules import make_score, score_kind, score_names
from hydrofdi.detectors.scores.contract import cross_fitted_scores, from_data, healthy_scale, plain_data
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import area_under_curve, learned_direction
from hydrofdi.evaluation.scores import suspicion


class Population:
    """Features that four uniform nuisances move along curves; a fault moves them along a line of its own."""

    def __init__(self, n_feature=6, noise=0.1, seed=1):
        self.draw, self.noise = np.random.default_rng(seed), noise
        shape = 4, n_feature
        self.slopes, self.curves = self.draw.normal(size=shape), 0.3 * self.draw.normal(size=shape)
        self.fault = self.draw.normal(size=n_feature)

    def records(self, n_record, severity=0.0):
        nuisance = self.draw.uniform(-1.0, 1.0, (n_record, 4))
        spread = self.noise * self.draw.normal(size=(n_record, self.fault.size))
        return nuisance @ self.slopes + nuisance**2 @ self.curves + severity * self.fault + spread

    def labelled(self, n_healthy, n_faulty, severity):
        values = np.vstack([self.records(n_healthy), self.records(n_faulty, severity)])
        return values, np.arange(n_healthy + n_faulty) >= n_healthy


every_score = pytest.mark.parametrize("name", score_names())
standardised = pytest.mark.parametrize("name", [name for name in score_names() if name != "largest_change"])


def fitted(name, values, is_faulty=None, **options):
    no_fault = np.zeros(len(values), dtype=bool)
    return make_score(name, options).fit(values, no_fault if is_faulty is None else is_faulty)


@every_score
def test_a_large_fault_is_found_in_records_that_were_not_fitted_on(name):
    population = Population()
    fit, test = population.labelled(300, 300, 2.0), population.labelled(500, 500, 2.0)
    score, model = score_kind(name), fitted(name, *fit)
    on_fit, on_test = model.score(fit[0]), model.score(test[0])
    direction = score.direction or learned_direction(on_fit[~fit[1]], on_fit[fit[1]])
    suspect = suspicion(on_test, direction, float(np.median(on_fit[~fit[1]])))
    assert area_under_curve(suspect[~test[1]], suspect[test[1]]).low > 0.6


@every_score
def test_a_record_scores_the_same_whatever_is_scored_with_it_and_not_if_it_is_not_measured(name):
    population = Population()
    model = fitted(name, *population.labelled(100, 100, 1.0))
    records = population.records(203, 0.5)
    together = model.score(records)
    for rows in (slice(0, 1), slice(5, 6), slice(3, 10), slice(0, 203, 7), slice(None, None, -1)):
        np.testing.assert_array_equal(model.score(records[rows]), together[rows])
    np.testing.assert_array_equal(model.score(np.asfortranarray(records)), together)
    assert model.score(records[:0]).shape == (0,)
    records[3, 0], records[7, 5], records[11] = np.nan, np.inf, np.nan
    together[[3, 7, 11]] = np.nan
    np.testing.assert_array_equal(model.score(records), together)


@every_score
def test_what_is_not_measured_teaches_nothing_and_faulty_records_only_scores_that_need_them(name):
    population = Population()
    values, is_faulty = population.labelled(100, 100, 1.0)
    records = population.records(20)
    expected = fitted(name, values, is_faulty).score(records)
    more = np.vstack([values, np.full((4, 6), np.nan)]), np.append(is_faulty, [True, False, True, False])
    np.testing.assert_array_equal(fitted(name, *more).score(records), expected)
    otherwise = values + 7.0 * np.outer(is_faulty, population.fault)
    is_same = np.array_equal(fitted(name, otherwise, is_faulty).score(records), expected)
    assert is_same != score_kind(name).needs_faulty


def damages(data):
    """Plain data of a rule with something wrong at each key."""
    for key, value in data.items():
        yield {name: part for name, part in data.items() if name != key}
        if isinstance(value, dict):
            yield from (data | {key: part} for part in damages(value))
            continue
        for damage in (None, "x", {}, True, [[[1.0]]], [1.0, [2.0]], float("nan")):
            yield data | {key: damage}
            if isinstance(value, list) and damage is not True:
                yield data | {key: [damage, *value[1:]]}


@every_score
def test_a_trained_rule_is_plain_data_that_scores_the_same_bits(name):
    population = Population()
    model, records = fitted(name, *population.labelled(100, 100, 1.0)), population.records(20, 1.0)
    text = json.dumps(plain_data(model), allow_nan=False)
    again = from_data(score_kind(name).Trained, json.loads(text))
    np.testing.assert_array_equal(again.score(records), model.score(records))
    for damaged in damages(json.loads(text)):
        with pytest.raises(ValueError, match=r"^[a-z_.]+: "):
            from_data(score_kind(name).Trained, damaged)


@standardised
def test_constant_features_and_units_do_nothing(name):
    population = Population()
    values, is_faulty = population.labelled(100, 100, 1.0)
    records = population.records(50, 0.5)
    expected = fitted(name, values, is_faulty).score(records)
    for constant in (0.0, 1e9 / 3.0):
        model = fitted(name, np.insert(values, 3, constant, axis=1), is_faulty)
        np.testing.assert_array_equal(model.score(np.insert(records, 3, constant + 1.0, axis=1)), expected)
    scale, offset = np.array([1.0, 1e6, 1e-9, 3.0, 1e3, 0.1]), np.array([0.0, 1e6, 1.0, -2.0, 0.0, 5.0])
    model = fitted(name, values * scale + offset, is_faulty)
    np.testing.assert_allclose(model.score(records * scale + offset), expected, rtol=1e-3, atol=1e-5)
    with pytest.raises(NotStatedError, match="var"):
        fitted(name, np.full((40, 3), 1.0 / 3.0), np.arange(40) >= 20)


def test_a_feature_that_is_mostly_the_same_still_tells():
    draw = np.random.default_rng(3)
    values = draw.normal(size=(400, 2))
    values[:, 1] = np.where(draw.uniform(size=400) < 0.1, 1.0, 0.0)
    distances = fitted("mahalanobis", values).score([[0.0, 0.0], [0.0, 3.0]])
    assert distances[1] > distances[0] + 25.0


@standardised
def test_single_wild_fit_records_do_not_rule_a_fit(name):
    population = Population(n_feature=5 if name == "compensated" else 8, seed=2)
    (values, is_faulty), (test, truth) = (population.labelled(400, 400, 0.6) for _ in range(2))
    wild, rows = values.copy(), np.arange(0, 800, 100)
    wild[rows, np.arange(8) % values.shape[1]] = 1e6 * (-1.0) ** np.arange(8)
    scores = [fitted(name, fit, is_faulty).score(test) for fit in (values, wild)]
    calm, ruled = (area_under_curve(each[~truth], each[truth]).value for each in scores)
    assert calm > (0.65 if name == "either" else 0.9)  # the fault is small in each feature
    assert abs(calm - ruled) < 0.05


@every_score
@pytest.mark.parametrize("has_some", [False, True])
def test_too_few_records_are_refused_in_a_sentence(name, has_some):
    n_measured = 0 if not has_some else 1 if name == "either" else 4
    values, is_faulty = Population().labelled(50, 50, 1.0)
    values[n_measured:50, 0] = np.nan
    with pytest.raises(NotStatedError, match=f"{n_measured}$"):
        fitted(name, values, is_faulty)


WITHOUT_THE_EXTRA = """
import sys
import numpy as np
from hydrofdi.errors import HydrofdiError
from hydrofdi.detectors.rules import make_score, score_kind, score_names
kinds = [score_kind(name) for name in score_names()]
assert "sklearn" not in sys.modules, "it is loaded only to fit"
sys.modules["sklearn"] = None
values, is_faulty = np.random.default_rng(1).normal(size=(80, 3)), np.arange(80) >= 40
for name in score_names():
    try:
        make_score(name).fit(values, is_faulty)
        print(name)
    except HydrofdiError as error:
        assert str(error) == f"the score {name} needs the extra: pip install 'hydrofdi[learn]'", error
"""


def test_without_the_extra_scores_say_what_to_install():
    done = subprocess.run([sys.executable, "-c", WITHOUT_THE_EXTRA], capture_output=True, text=True)
    assert done.stdout.split() == ["compensated", "either", "largest_change"], done.stderr


@pytest.mark.parametrize("shrinkage", [0.0, 0.2])
def test_the_distance_is_that_of_the_textbook_with_the_stated_shrinkage_of_standardised_features(shrinkage):
    draw = np.random.default_rng(3)
    fit, records = draw.normal(size=(30, 10)) * np.logspace(0, 6, 10), draw.normal(size=(20, 10))
    low, centre, high = np.quantile(fit, [0.25, 0.5, 0.75], axis=0)
    scale = (high - low) / 1.3489795003921634
    reference = ShrunkCovariance(shrinkage=shrinkage).fit((fit - centre) / scale)
    found = fitted("mahalanobis", fit, shrinkage=shrinkage).score(records)
    np.testing.assert_allclose(found, reference.mahalanobis((records - centre) / scale), rtol=1e-9)


def test_the_shrinkage_that_fit_records_choose_leaves_small_faults_across_nuisances():
    """Four nuisances rule 20 features, so that healthy records hardly vary along the fault."""
    population = Population(n_feature=20, noise=0.03, seed=4)
    fit, healthy, faulty = (population.records(300, severity) for severity in (0.0, 0.0, 0.03))
    areas = []
    for options in ({}, {"shrinkage": LedoitWolf().fit(fit).shrinkage_}):
        model = fitted("mahalanobis", fit, **options)
        areas.append(area_under_curve(model.score(healthy), model.score(faulty)).value)
    assert areas[0] > areas[1] + 0.1


def test_one_class_sees_a_hole_among_healthy_records_and_the_distance_does_not():
    draw = np.random.default_rng(7)
    angles, noise = draw.uniform(0.0, 2.0 * np.pi, (2, 300)), 0.05 * draw.normal(size=(2, 300, 2))
    fit, healthy = np.stack([np.cos(angles), np.sin(angles)], axis=2) + noise
    faulty = 0.1 * draw.normal(size=(300, 2))
    one_class, distance = fitted("one_class", fit, width=0.3), fitted("mahalanobis", fit)
    assert area_under_curve(one_class.score(healthy), one_class.score(faulty)).low > 0.95
    assert area_under_curve(distance.score(healthy), distance.score(faulty)).high < 0.05


@pytest.mark.parametrize("outside", [0.02, 0.3])
def test_at_most_the_stated_share_lies_outside_the_boundary_of_the_support_vector_machine(outside):
    fit = Population(seed=8).records(1000)
    model = fitted("one_class", fit, outside=outside)
    assert 0.3 * outside < np.mean(model.score(fit) > 1e-2) <= outside
    machine = OneClassSVM(gamma=model.gamma, nu=outside).fit(model.white(fit))
    records = Population(seed=8).records(50, 1.0)
    expected = -machine.decision_function(model.white(records))
    np.testing.assert_allclose(model.score(records), expected, atol=1e-12)


def test_a_healthy_scale_leaves_out_what_is_missing():
    centre, spread = healthy_scale(np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]]))
    assert (centre, spread) == (3.0, pytest.approx(2.0 / 1.34898, rel=1e-5))
    for scores in (np.ones(10), np.arange(4.0)):
        with pytest.raises(NotStatedError):
            healthy_scale(scores)


SPREAD = 0.05


def records(draw, n_record, fault=0.0, nuisance=(-1.0, 1.0), proxy_fault=0.0):
    """A feature that a nuisance moves by 10 spreads and more, beside a proxy of the nuisance."""
    stiffness = draw.uniform(*nuisance, n_record)
    feature = 3.0 + 2.0 * stiffness - stiffness**2 + fault + SPREAD * draw.normal(size=n_record)
    return np.stack([feature, 500.0 + 100.0 * stiffness + proxy_fault], axis=1)


def test_a_nuisance_goes_and_the_effect_of_the_fault_stays():
    draw = np.random.default_rng(1)
    model = fitted("compensated", records(draw, 500))
    healthy, faulty = model.score(records(draw, 500)), model.score(records(draw, 500, fault=-0.4))
    assert np.std(healthy) == pytest.approx(SPREAD, rel=0.1)
    assert np.mean(healthy) == pytest.approx(0.0, abs=0.01)
    assert np.mean(faulty) == pytest.approx(-0.4, abs=0.01)
    raw = area_under_curve(records(draw, 500, fault=-0.4)[:, 0], records(draw, 500)[:, 0]).value
    assert area_under_curve(faulty, healthy).value > 0.99 > 0.7 > raw


def test_beyond_the_range_of_the_fit_a_proxy_counts_as_at_its_end():
    draw = np.random.default_rng(3)
    fit = records(draw, 500)
    model, last = fitted("compensated", fit), fit[np.argmax(fit[:, 1])]
    beyond = last + np.array([[0.0, 0.0], [0.0, 50.0], [0.0, 1e6], [0.7, 1e6]])
    scores = model.score(beyond)
    np.testing.assert_array_equal(scores[1:3], scores[0])
    assert scores[3] == pytest.approx(scores[0] + 0.7)


COVARIANCE = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.3], [0.0, 0.3, 2.0]])
DISTANCE = np.array([0.5, -0.3, 0.2])
WEIGHTS = np.linalg.solve(COVARIANCE, DISTANCE)
"""Of the best line, and of the true log-odds: Anderson, Multivariate Analysis (2003), 6.4."""


@pytest.mark.parametrize("name", ["lda", pytest.param("logistic", marks=pytest.mark.long)])
def test_weights_are_those_of_the_true_log_odds(name):
    draw = np.random.default_rng(1)
    is_faulty = np.arange(100_000) >= 50_000
    values = draw.multivariate_normal(np.zeros(3), COVARIANCE, size=100_000) + np.outer(is_faulty, DISTANCE)
    origin, *ends = fitted(name, values, is_faulty).score(np.eye(4, 3, -1))
    np.testing.assert_allclose(ends - origin, WEIGHTS, atol=0.05)


def test_lda_weighs_both_kinds_alike_however_many_records_they_have():
    draw = np.random.default_rng(8)
    spreads, apart = np.array([[1.0, 1.0], [1.0, 3.0]]), np.array([1.0, 1.0])
    healthy, faulty = (
        draw.normal(size=(n, 2)) * each for n, each in zip((50_000, 5_000), spreads, strict=True)
    )
    is_faulty = np.arange(55_000) >= 50_000
    model = make_score("lda").fit(np.vstack([healthy, faulty + apart]), is_faulty)
    origin, *ends = model.score(np.eye(3, 2, -1))
    np.testing.assert_allclose(ends - origin, apart / np.mean(spreads**2, axis=0), atol=0.05)
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


def test_records_that_are_no_fit_records_teach_nothing_and_those_without_a_group_are_their_own():
    lda, (values, is_faulty) = make_score("lda"), Population(seed=4).labelled(60, 60, 1.0)
    is_fit = np.arange(120) % 3 > 0
    scores = cross_fitted_scores(lda, values, is_faulty, is_fit=is_fit)
    model = lda.fit(values[is_fit], is_faulty[is_fit])
    np.testing.assert_array_equal(scores[~is_fit], model.score(values[~is_fit]))
    wild = np.where(is_fit[:, None], values, 1e3 * values)
    others = cross_fitted_scores(lda, wild, is_faulty, is_fit=is_fit)
    np.testing.assert_array_equal(others[is_fit], scores[is_fit])
    named = [f"{row:03}" for row in range(120)]
    np.testing.assert_array_equal(
        cross_fitted_scores(lda, values, is_faulty, named), cross_fitted_scores(lda, values, is_faulty)
    )
    apart = cross_fitted_scores(lda, values, is_faulty, [""] * 120, n_fold=120)
    np.testing.assert_array_equal(apart, cross_fitted_scores(lda, values, is_faulty, n_fold=120))


def test_every_fold_has_both_kinds():
    values, is_faulty = Population(seed=7).labelled(95, 6, 5.0)
    for seed in range(10):
        scores = cross_fitted_scores(make_score("lda"), values, is_faulty, n_fold=6, seed=seed)
        assert np.isfinite(scores).all()
