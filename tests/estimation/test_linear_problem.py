"""On a linear problem all filters are the Kalman filter."""

import numpy as np
import pytest

from estimation.filters import KalmanFilter, UnscentedFilter
from hydrofdi.estimation.plant import N_MOVING, N_STATE


def linear_problem(random):
    """Transition, noise and prior of a plant whose held states walk."""
    transition = np.eye(N_STATE)
    transition[:N_MOVING] = random.normal(size=(N_MOVING, N_STATE))
    transition[:N_MOVING, :N_MOVING] = 0.9 * np.linalg.qr(random.normal(size=(N_MOVING, N_MOVING)))[0]
    noise, factor = np.abs(random.normal(size=N_STATE)), random.normal(size=(N_STATE, N_STATE))
    return transition, noise, factor @ factor.T + np.eye(N_STATE)


@pytest.mark.parametrize("spread", [1.0, 0.1])
def test_the_unscented_filter_is_the_kalman_filter(spread):
    random = np.random.default_rng(3)
    transition, noise, prior = linear_problem(random)
    truth, deviations = random.normal(size=N_STATE), np.array([0.3, 0.01, 2.0])
    kalman = KalmanFilter(np.zeros(N_STATE), prior)
    unscented = UnscentedFilter(kalman.mean, prior, spread)
    for _ in range(200):
        truth = transition @ truth + noise * random.normal(size=N_STATE)
        values = dict(enumerate(truth[:3] + deviations * random.normal(size=3)))
        kalman.predict(transition, noise)
        kalman.measure(values, deviations)
        unscented.predict(lambda points: transition @ points, noise)
        unscented.measure(values, deviations)
        np.testing.assert_allclose(unscented.mean, kalman.mean, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(unscented.covariance, kalman.covariance, rtol=1e-9, atol=1e-9)
