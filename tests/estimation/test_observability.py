"""What outputs tell of states and parameters: Gramians of linear systems."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from hydrofdi.estimation.observability import (
    correlations,
    covariance_with_prior,
    finite_horizon_gramian,
    spectrum,
)

A = np.array([[0.9, 0.2, 0.0], [-0.1, 0.8, 0.1], [0.0, 0.0, 0.7]])
C = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]])
NOISE = np.array([0.1, 0.3])


def repeated(matrix, n_step):
    return np.broadcast_to(matrix, (n_step, *matrix.shape))


def test_a_long_horizon_has_the_gramian_of_lyapunovs_equation():
    wanted = solve_discrete_lyapunov(A.T, C.T @ np.diag(NOISE**-2.0) @ C)
    assert finite_horizon_gramian(repeated(A, 400), C, NOISE) == pytest.approx(wanted, rel=1e-10)


def test_two_steps_of_a_changing_system_are_summed_by_hand():
    transitions = np.array([A, 2.0 * A.T])
    weighed = C / NOISE[:, None]
    rows = np.vstack([weighed, weighed @ A, weighed @ (2.0 * A.T) @ A])
    assert finite_horizon_gramian(transitions, C, NOISE) == pytest.approx(rows.T @ rows, rel=1e-12)


def test_a_direction_that_no_output_shows_is_named():
    gramian = finite_horizon_gramian(repeated(np.eye(3), 10), np.array([[1.0, 1.0, 0.0]]), np.ones(1))
    found = spectrum(gramian)
    assert found.values == pytest.approx([22.0, 0.0, 0.0])
    assert found.condition == math.inf
    assert not found.values[1:].any()
    known = spectrum(gramian + np.diag([0.0, 0.0, 5.0]))
    assert abs(known.directions[-1] @ [0.5**0.5, -(0.5**0.5), 0.0]) == pytest.approx(1.0)


def test_what_is_only_known_as_a_sum_is_collinear_behind_the_record():
    covariance = covariance_with_prior(1e4 * np.array([[1.0, 1.0], [1.0, 1.0]]))
    assert correlations(covariance)[0, 1] < -0.999
    assert correlations(covariance_with_prior(np.zeros((2, 2))))[0, 1] == 0.0
