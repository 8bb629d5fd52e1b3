"""What every score keeps to, whatever it learns."""

import json
import subprocess
import sys

import numpy as np
import pytest

from hydrofdi.detectors.rules import make_score, score_kind, score_names
from hydrofdi.detectors.scores.contract import from_data, plain_data
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import area_under_curve, learned_direction
from hydrofdi.evaluation.scores import suspicion
from tests.detectors.scores.populations import Population

every_score = pytest.mark.parametrize("name", score_names())
standardised = pytest.mark.parametrize("name", [name for name in score_names() if name != "largest_change"])


@pytest.fixture
def population():
    return Population(seed=1)


def fitted(name, values, is_faulty):
    return make_score(name).fit(values, is_faulty)


@every_score
def test_a_large_fault_is_found_in_records_that_were_not_fitted_on(name, population):
    fit, test = population.labelled(300, 300, 2.0), population.labelled(500, 500, 2.0)
    score, model = score_kind(name), fitted(name, *fit)
    on_fit, on_test = model.score(fit[0]), model.score(test[0])
    direction = score.direction or learned_direction(on_fit[~fit[1]], on_fit[fit[1]])
    suspect = suspicion(on_test, direction, float(np.median(on_fit[~fit[1]])))
    assert area_under_curve(suspect[~test[1]], suspect[test[1]]).low > 0.6


@every_score
def test_a_record_scores_the_same_whatever_is_scored_with_it_and_has_no_score_if_it_is_not_measured(
    name, population
):
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
def test_what_is_not_measured_teaches_nothing_and_faulty_records_only_scores_that_need_them(name, population):
    values, is_faulty = population.labelled(100, 100, 1.0)
    records = population.records(20)
    expected = fitted(name, values, is_faulty).score(records)
    more = np.vstack([values, np.full((4, 6), np.nan)])
    model = fitted(name, more, np.append(is_faulty, [True, False, True, False]))
    np.testing.assert_array_equal(model.score(records), expected)
    otherwise = values + np.where(is_faulty, 7.0, 0.0)[:, None] * population.fault
    assert (fitted(name, otherwise, is_faulty).score(records) == expected).all() != score_kind(
        name
    ).needs_faulty


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
def test_a_trained_rule_is_plain_data_that_scores_the_same_bits(name, population):
    model, records = fitted(name, *population.labelled(100, 100, 1.0)), population.records(20, 1.0)
    text = json.dumps(plain_data(model), allow_nan=False)
    again = from_data(score_kind(name).Trained, json.loads(text))
    np.testing.assert_array_equal(again.score(records), model.score(records))
    for damaged in damages(json.loads(text)):
        with pytest.raises(ValueError, match=r"^[a-z_.]+: "):
            from_data(score_kind(name).Trained, damaged)


def test_the_boundary_of_one_class_is_that_of_the_support_vector_machine(population):
    from sklearn.svm import OneClassSVM

    values, is_faulty = population.labelled(100, 100, 1.0)
    model, records = fitted("one_class", values, is_faulty), population.records(50, 1.0)
    white = model.white
    machine = OneClassSVM(gamma=model.gamma, nu=0.1).fit(white(values[~is_faulty]))
    np.testing.assert_allclose(model.score(records), -machine.decision_function(white(records)), atol=1e-12)


@standardised
def test_constant_features_and_units_do_nothing(name, population):
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
    distances = fitted("mahalanobis", values, np.zeros(400, dtype=bool)).score([[0.0, 0.0], [0.0, 3.0]])
    assert distances[1] > distances[0] + 25.0


@standardised
def test_single_wild_fit_records_do_not_rule_a_fit(name):
    population = Population(n_feature=5 if name == "compensated" else 8, seed=2)
    values, is_faulty = population.labelled(400, 400, 0.6)
    test, truth = population.labelled(400, 400, 0.6)
    wild, rows = values.copy(), np.arange(0, 800, 100)
    wild[rows, np.arange(8) % values.shape[1]] = 1e6 * (-1.0) ** np.arange(8)
    scores = [fitted(name, fit, is_faulty).score(test) for fit in (values, wild)]
    calm, ruled = (area_under_curve(each[~truth], each[truth]).value for each in scores)
    assert calm > (0.65 if name == "either" else 0.9)  # the fault is small in each feature
    assert abs(calm - ruled) < 0.05


@every_score
@pytest.mark.parametrize("has_some", [False, True])
def test_too_few_records_are_refused_in_a_sentence(name, has_some, population):
    n_measured = 0 if not has_some else 1 if name == "either" else 4
    values, is_faulty = population.labelled(50, 50, 1.0)
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
    assert (done.returncode, done.stdout.split()) == (0, ["compensated", "either", "largest_change"]), (
        done.stderr
    )
