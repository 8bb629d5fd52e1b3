"""The unscented transform and roots of covariances against published sums and full matrices."""

import numpy as np
import pytest

from estimation.filters import UnscentedFilter
from hydrofdi.indicators.estimation.square_root import find_gain, grow, shrink, triangularise

N = 5


def merwe_moments(mean, covariance, spread, model):
    """Mean and covariance by the sums of van der Merwe and Wan, with kappa = 0 and beta = 2."""
    n = len(mean)
    scale = spread**2 * n
    ways = np.linalg.cholesky(scale * covariance)
    moved = model(mean[:, None] + np.hstack([np.zeros((n, 1)), ways, -ways]))
    weights = np.full(2 * n + 1, 0.5 / scale)
    weights[0] = 1.0 - n / scale
    moved_mean = moved @ weights
    ways = moved - moved_mean[:, None]
    weights[0] += 1.0 - spread**2 + 2.0
    return moved_mean, (ways * weights) @ ways.T


@pytest.fixture
def random():
    return np.random.default_rng(7)


def drawn_covariance(random):
    factor = random.normal(size=(N, N))
    return factor @ factor.T + 0.1 * np.eye(N)


@pytest.mark.parametrize("spread", [1.0, 0.5, 0.03])
def test_a_nonlinear_model_has_the_published_sums(random, spread):
    def model(points):
        return np.sin(points) + points[::-1] ** 2

    mean, covariance = random.normal(size=N), drawn_covariance(random)
    unscented = UnscentedFilter(mean, covariance, spread)
    unscented.predict(model, np.zeros(N))
    expected_mean, expected_covariance = merwe_moments(mean, covariance, spread, model)
    np.testing.assert_allclose(unscented.mean, expected_mean, rtol=1e-8)
    np.testing.assert_allclose(unscented.covariance, expected_covariance, rtol=1e-8, atol=1e-8)


def test_the_square_of_a_normal_variable_has_its_moments():
    unscented = UnscentedFilter(np.zeros(N), np.diag([4.0, 1.0, 1.0, 1.0, 1.0]), spread=0.01)
    unscented.predict(lambda points: points**2, np.zeros(N))
    assert unscented.mean[0] == pytest.approx(4.0)
    assert unscented.covariance[0, 0] == pytest.approx(2.0 * 4.0**2, rel=1e-3)


def test_reflections_keep_the_square_of_a_matrix_with_columns_of_zeros(random):
    rows = random.normal(size=(9, N))
    rows[:, 2] = 0.0
    square = rows.T @ rows
    rows = np.vstack([rows, np.zeros(N)])
    triangularise(rows, 9)
    upper = np.triu(rows[:N])
    np.testing.assert_allclose(upper.T @ upper, square, atol=1e-12)


@pytest.mark.parametrize("trusted", [5, 3])
def test_a_measurement_with_any_gain_has_joseph_s_covariance(random, trusted):
    root, gain, variance, k = np.linalg.cholesky(drawn_covariance(random)), np.zeros(N), 0.3, 2
    covariance = root @ root.T
    total = find_gain(root, k, variance, gain)
    assert total == pytest.approx(covariance[k, k] + variance)
    np.testing.assert_allclose(gain, covariance[k] / total, rtol=1e-12)
    error, gain = np.where(np.arange(N) < trusted, 0.0, gain), np.where(np.arange(N) < trusted, gain, 0.0)
    kept = np.eye(N) - np.outer(gain, np.eye(N)[k])
    expected = kept @ covariance @ kept.T + variance * np.outer(gain, gain)
    shrink(root, k, variance / total, gain + error)
    grow(root, np.sqrt(total) * error, np.zeros((N + 2, N)))
    np.testing.assert_allclose(root @ root.T, expected, atol=1e-12)


def test_the_order_of_measurements_does_not_matter(random):
    covariance = drawn_covariance(random)
    first, second = (UnscentedFilter(np.zeros(N), covariance) for _ in range(2))
    first.measure({0: 1.0, 1: -2.0, 2: 0.5}, [0.1, 1.0, 10.0])
    second.measure({2: 0.5, 1: -2.0, 0: 1.0}, [10.0, 1.0, 0.1])
    np.testing.assert_allclose(first.mean, second.mean, atol=1e-12)
    np.testing.assert_allclose(first.covariance, second.covariance, atol=1e-12)


def test_almost_exact_measurements_leave_a_positive_covariance():
    """The covariance by subtraction turns negative here."""
    unscented = UnscentedFilter(np.zeros(N), 1e6 * (np.ones((N, N)) + 1e-9 * np.eye(N)))
    for _ in range(100):
        unscented.measure({0: 1.0, 1: 1.0}, [1e-6, 1e-6])
        assert np.linalg.svd(unscented.root, compute_uv=False).min() > 0.0
    assert np.sqrt(unscented.covariance[0, 0]) == pytest.approx(1e-7, rel=1e-2)


def test_filterpy_gives_the_same_estimates(random):
    kalman = pytest.importorskip("filterpy.kalman")

    def move(points):
        return points + 0.1 * np.sin(points[::-1]) - 0.02 * points**3

    noise, deviations = np.full(N, 0.1), np.array([0.2, 0.3])
    points = kalman.MerweScaledSigmaPoints(N, alpha=0.5, beta=2.0, kappa=0.0)
    oracle = kalman.UnscentedKalmanFilter(
        N, 2, 1.0, fx=lambda point, _: move(point), hx=lambda point: point[:2], points=points
    )
    oracle.Q, oracle.R = np.diag(noise**2), np.diag(deviations**2)
    unscented = UnscentedFilter(np.zeros(N), np.eye(N), spread=0.5)
    for values in random.normal(size=(100, 2)):
        unscented.root = np.linalg.cholesky(unscented.covariance)  # the root that filterpy takes
        oracle.predict()
        oracle.update(values)
        unscented.predict(move, noise)
        unscented.measure(dict(enumerate(values)), deviations)
        np.testing.assert_allclose(unscented.mean, oracle.x, rtol=0, atol=1e-9)
        np.testing.assert_allclose(unscented.covariance, oracle.P, rtol=0, atol=1e-9)
