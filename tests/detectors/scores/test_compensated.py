"""A feature less what its proxies tell of it."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import make_score
from hydrofdi.evaluation.roc import area_under_curve

SPREAD = 0.05


def records(draw, n_record, fault=0.0, nuisance=(-1.0, 1.0), proxy_fault=0.0):
    """A feature that a nuisance moves by 10 spreads and more, beside a proxy of the nuisance."""
    stiffness = draw.uniform(*nuisance, n_record)
    feature = 3.0 + 2.0 * stiffness - stiffness**2 + fault + SPREAD * draw.normal(size=n_record)
    return np.stack([feature, 500.0 + 100.0 * stiffness + proxy_fault], axis=1)


def fitted(values, is_faulty=None):
    return make_score("compensated").fit(
        values, np.zeros(len(values), bool) if is_faulty is None else is_faulty
    )


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
