"""Recursive least squares and Volterra kernels against one regression."""

from math import comb

import numpy as np
import pytest

from estimation.filters import ExtendedFilter, KalmanFilter, UnscentedFilter
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.catalogue import volterra
from hydrofdi.indicators.estimation import weak_rls
from hydrofdi.indicators.estimation.chamber_balance import N_UNKNOWN
from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE

ERROR = 4e-9


def equations(seed, n_window, n_chamber=2):
    """Columns, in units of the priors, with targets of known unknowns and errors below the stated one."""
    draw = np.random.default_rng(seed)
    columns = draw.normal(size=(1, n_window, n_chamber, N_UNKNOWN)) * ERROR
    truth = np.abs(draw.normal(size=N_UNKNOWN))
    targets = columns @ truth + 0.7 * ERROR * draw.normal(size=columns.shape[:3])
    return columns, targets, truth


def followed(columns, targets, due, memory=np.inf, deviations=None, counts=None, state=None):
    """Estimates (n_instant, N_ESTIMATE) after so many windows."""
    deviations = np.ones(N_UNKNOWN) if deviations is None else deviations
    counts = np.ones(columns.shape[:2]) if counts is None else counts
    state = weak_rls.new_state(1, columns.shape[2]) if state is None else state
    out, priors = np.full((1, len(due), weak_rls.N_ESTIMATE), np.nan), np.zeros((1, len(due), N_UNKNOWN))
    known, decay = weak_rls.Assumptions(deviations, ERROR, 1.0, 0.032, 1e-12), float(np.exp(-1.0 / memory))
    given = columns, targets, counts, np.array(due), priors, known, decay, state, weak_rls.new_scratch(), out
    weak_rls.follow_windows(*given)
    return out[0]


@pytest.mark.parametrize("known", [[], [3, 7]])
def test_with_all_in_memory_the_estimates_are_those_of_one_regression(known):
    columns, targets, truth = equations(2, 400)
    deviations = np.ones(N_UNKNOWN)
    deviations[known] = 0.0
    targets = targets - columns[..., known] @ truth[known]
    found = followed(columns, targets, [400], deviations=deviations)[0]
    assert (found[[*known, *(N_UNKNOWN + k for k in known)]] == 0.0).all()
    rest = np.delete(np.arange(N_UNKNOWN), known)
    some = columns[0].reshape(800, -1)[:, rest] / ERROR
    expected = np.linalg.solve(np.eye(len(rest)) + some.T @ some, some.T @ targets.reshape(800) / ERROR)
    np.testing.assert_allclose(found[rest], expected, rtol=1e-9)
    rows, left = columns[0].reshape(800, -1) * deviations / ERROR, targets - columns @ found[:N_UNKNOWN]
    np.testing.assert_allclose(found[weak_rls.MISFIT], np.sqrt(np.mean(left**2)) / ERROR, rtol=1e-9)
    normal = np.eye(N_UNKNOWN) + rows.T @ rows
    scaled = normal / np.sqrt(np.outer(np.diag(normal), np.diag(normal)))
    np.testing.assert_allclose(found[weak_rls.CONDITION] ** 2, np.linalg.cond(scaled, 1), rtol=1e-9)


def test_what_is_not_excited_any_more_returns_to_its_prior():
    columns, targets, truth = equations(3, 4000)
    columns[:, 1000:, :, 4] = 0.0
    targets[:, 1000:] = columns[:, 1000:] @ truth
    at_once, late = followed(columns, targets, [1000, 4000], memory=100.0)
    assert abs(at_once[4] - truth[4]) < 0.5
    assert at_once[N_UNKNOWN + 4] < 0.2
    assert abs(late[4]) < 1e-6
    np.testing.assert_allclose(late[N_UNKNOWN + 4], 1.0, rtol=1e-6)
    np.testing.assert_allclose(np.delete(late[:N_UNKNOWN], 4), np.delete(truth, 4), atol=0.05)


def test_windows_that_do_not_count_only_let_time_pass_and_a_gap_is_a_status_from_then_on():
    columns, targets, _ = equations(4, 60)
    gap, counts, deviations = targets.copy(), np.ones((1, 60)), slice(N_UNKNOWN, 2 * N_UNKNOWN)
    counts[0, 20:] = 0.0
    gap[0, 30, 0] = np.nan
    found = followed(columns, gap, [30, 31, 60])
    assert np.isfinite(found[0, : weak_rls.DISAGREEMENT]).all()
    assert np.isnan(found[1:]).all()
    columns[:, 20:], targets[:, 20:] = np.nan, np.nan
    early, late = followed(columns, targets, [20, 60], counts=counts)
    np.testing.assert_array_equal(late[:N_UNKNOWN], early[:N_UNKNOWN])
    early, late = followed(columns, targets, [20, 60], counts=counts, memory=10.0)
    assert (late[deviations] > early[deviations]).all()


@pytest.mark.parametrize("spread", [1.0, 0.1])
def test_the_filters_are_the_kalman_filter(spread):
    """Of a plant whose held states walk."""
    random, transition = np.random.default_rng(3), np.eye(N_STATE)
    transition[:N_MOVING] = random.normal(size=(N_MOVING, N_STATE))
    transition[:N_MOVING, :N_MOVING] = 0.9 * np.linalg.qr(random.normal(size=(N_MOVING, N_MOVING)))[0]
    noise, factor = np.abs(random.normal(size=N_STATE)), random.normal(size=(N_STATE, N_STATE))
    prior, start = factor @ factor.T + np.eye(N_STATE), np.zeros(N_STATE)
    truth, deviations = random.normal(size=N_STATE), np.array([0.3, 0.01, 2.0])
    kalman = KalmanFilter(start, prior)
    extended, unscented = ExtendedFilter(start, prior), UnscentedFilter(start, prior, spread)
    for _ in range(200):
        truth = transition @ truth + noise * random.normal(size=N_STATE)
        values = dict(enumerate(truth[:3] + deviations * random.normal(size=3)))
        kalman.predict(transition, noise)
        extended.predict(transition, noise)
        unscented.predict(lambda points: transition @ points, noise)
        for each in (kalman, extended, unscented):
            each.measure(values, deviations)
        for each in (extended, unscented):
            np.testing.assert_allclose(each.mean, kalman.mean, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(each.covariance, kalman.covariance, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("order", "n_given", "n_own"), [(1, 1, 1), (2, 3, 2), (3, 2, 0)])
def test_a_known_system_has_its_coefficients_one_for_each_product(order, n_given, n_own):
    draw = np.random.default_rng(order)
    (model,) = make_indicators({"volterra": {"order": order, "input_lags": n_given, "lags": n_own}}).values()
    terms = model._terms
    assert len(set(terms)) == len(terms) == comb(n_given + n_own + order, order)
    coefficients = draw.uniform(-0.3, 0.3, len(terms)) / len(terms)
    given, signal, start = draw.uniform(-1.0, 1.0, 1500), np.zeros(1500), max(n_given, n_own)
    for k in range(start, given.size):
        values = [given[k - lag] for lag in range(1, n_given + 1)]
        values += [signal[k - lag] for lag in range(1, n_own + 1)]
        signal[k] = np.dot(coefficients, [np.prod([values[place] for place in term]) for term in terms])
    columns = volterra.regressors(given, signal, n_given, n_own, terms)
    found, left = volterra.ridge_regression(columns, signal[start:], 0.0)
    np.testing.assert_allclose(found, coefficients, atol=1e-8)
    assert left < 1e-10
    assert model.outputs[0].long_name.startswith("coefficients of 1, u1, " + ("y1" if n_given == 1 else "u2"))


def test_a_ridge_is_that_of_the_normal_equations_and_what_is_not_determined_has_no_number():
    draw = np.random.default_rng(0)
    columns, target = draw.normal(size=(50, 4)), draw.normal(size=50)
    expected = np.linalg.solve(columns.T @ columns + 0.1 * 50 * np.eye(4), columns.T @ target)
    np.testing.assert_allclose(volterra.ridge_regression(columns, target, 0.1)[0], expected, rtol=1e-10)
    columns, target = np.ones((20, 2)), np.ones(20)
    assert np.isnan(volterra.ridge_regression(columns, target, 0.0)[0]).all()
    assert np.isfinite(volterra.ridge_regression(columns, target, 1e-6)[0]).all()
    target[3] = np.nan
    assert np.isnan(volterra.ridge_regression(columns, target, 1e-6)[0]).all()
