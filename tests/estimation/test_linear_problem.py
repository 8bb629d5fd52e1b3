"""On a linear problem all filters are the Kalman filter."""

import numpy as np
import pytest

from estimation.filters import ExtendedFilter, KalmanFilter, UnscentedFilter
from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE


def linear_problem(random):
    """Transition, noise and prior of a plant whose held states walk."""
    transition = np.eye(N_STATE)
    transition[:N_MOVING] = random.normal(size=(N_MOVING, N_STATE))
    transition[:N_MOVING, :N_MOVING] = 0.9 * np.linalg.qr(random.normal(size=(N_MOVING, N_MOVING)))[0]
    noise, factor = np.abs(random.normal(size=N_STATE)), random.normal(size=(N_STATE, N_STATE))
    return transition, noise, factor @ factor.T + np.eye(N_STATE)


@pytest.mark.parametrize("spread", [1.0, 0.1])
def test_the_filters_are_the_kalman_filter(spread):
    random = np.random.default_rng(3)
    transition, noise, prior = linear_problem(random)
    truth, deviations = random.normal(size=N_STATE), np.array([0.3, 0.01, 2.0])
    kalman = KalmanFilter(np.zeros(N_STATE), prior)
    extended, unscented = ExtendedFilter(kalman.mean, prior), UnscentedFilter(kalman.mean, prior, spread)
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
