"""Nonlinear autoregressive models: a known system's coefficients come back."""

from math import comb

import numpy as np
import pytest

from hydrofdi.indicators.models.volterra import (
    block_means,
    lagged_values,
    polynomial_terms,
    regressors,
    ridge_regression,
)


def response(given, n_given, n_own, terms, coefficients):
    """What a system of known coefficients makes of its input, value by value."""
    start, signal = max(n_given, n_own), np.zeros(given.size)
    for k in range(start, given.size):
        values = [given[k - lag] for lag in range(1, n_given + 1)]
        values += [signal[k - lag] for lag in range(1, n_own + 1)]
        products = [np.prod([values[place] for place in term]) for term in terms]
        signal[k] = np.dot(coefficients, products)
    return signal


@pytest.mark.parametrize(
    ("order", "n_given", "n_own"), [(1, 1, 1), (2, 1, 1), (2, 3, 2), (3, 2, 1), (2, 4, 0), (3, 3, 0)]
)
def test_a_known_system_has_its_coefficients(order, n_given, n_own):
    draw = np.random.default_rng(order)
    terms = polynomial_terms(n_given + n_own, order)
    coefficients = draw.uniform(-0.3, 0.3, len(terms)) / len(terms)
    given = draw.uniform(-1.0, 1.0, 1500)
    signal = response(given, n_given, n_own, terms, coefficients)
    columns = regressors(given, signal, n_given, n_own, terms)
    found, left = ridge_regression(columns, signal[max(n_given, n_own) :], 0.0)
    np.testing.assert_allclose(found, coefficients, atol=1e-8)
    assert left < 1e-10


@pytest.mark.parametrize(("n_value", "order"), [(1, 1), (2, 2), (5, 2), (3, 4)])
def test_there_is_a_term_for_each_product(n_value, order):
    terms = polynomial_terms(n_value, order)
    assert len(set(terms)) == len(terms) == comb(n_value + order, order)
    assert terms[: n_value + 1] == ((), *((place,) for place in range(n_value)))


def test_lagged_values_are_named_in_the_order_of_the_terms():
    assert lagged_values("u", 2, "y", 1) == ("u1", "u2", "y1")
    given, signal = np.arange(10.0), 100.0 + np.arange(10.0)
    columns = regressors(given, signal, 2, 1, polynomial_terms(3, 1))
    np.testing.assert_array_equal(columns[0], [1.0, given[1], given[0], signal[1]])


def test_a_ridge_is_that_of_the_normal_equations():
    draw = np.random.default_rng(0)
    columns, target = draw.normal(size=(50, 4)), draw.normal(size=50)
    expected = np.linalg.solve(columns.T @ columns + 0.1 * 50 * np.eye(4), columns.T @ target)
    np.testing.assert_allclose(ridge_regression(columns, target, 0.1)[0], expected, rtol=1e-10)


def test_what_is_not_determined_has_no_number():
    columns, target = np.ones((20, 2)), np.ones(20)
    assert np.isnan(ridge_regression(columns, target, 0.0)[0]).all()
    assert np.isfinite(ridge_regression(columns, target, 1e-6)[0]).all()
    target[3] = np.nan
    assert np.isnan(ridge_regression(columns, target, 1e-6)[0]).all()


def test_means_leave_out_a_block_that_is_not_complete():
    np.testing.assert_array_equal(block_means(np.arange(11.0)[None], 3), [[1.0, 4.0, 7.0]])
