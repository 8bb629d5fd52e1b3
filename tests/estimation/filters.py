"""Filters of any model, put together from the parts that the kernels use."""

import numpy as np

from hydrofdi.indicators.estimation import ekf
from hydrofdi.indicators.estimation.plant import N_MOVING
from hydrofdi.indicators.estimation.ukf import find_gain, gather_points, measurement_update, place_points


class UnscentedFilter:
    """A square-root filter of a model that moves columns of points."""

    def __init__(self, mean, covariance, spread=1.0):
        n = len(mean)
        self.mean, self.root, self.spread = mean.copy(), np.linalg.cholesky(covariance), spread
        self.places = np.arange(n)
        self.points, self.rows, self.gain = np.zeros((n, 2 * n + 1)), np.zeros((3 * n + 2, n)), np.zeros(n)

    @property
    def covariance(self):
        return self.root @ self.root.T

    def predict(self, model, noise):
        place_points(self.mean, self.root, self.spread, self.places, self.points)
        moved = model(self.points)
        gather_points(moved, self.places, self.spread, noise, self.mean, self.root, self.rows)

    def measure(self, values, deviations):
        """Take in {state: value}."""
        for (k, value), deviation in zip(values.items(), deviations, strict=True):
            variance = find_gain(self.root, k, deviation**2, self.gain)
            self.mean += self.gain * (value - self.mean[k])
            measurement_update(self.root, k, deviation**2 / variance, self.gain)


class ExtendedFilter:
    """The filter of a plant whose held states walk, with a transition that is given."""

    def __init__(self, mean, covariance):
        n = len(mean)
        self.mean, self.covariance = mean.copy(), covariance.copy()
        self.rows, self.gain, self.row = np.zeros((N_MOVING, n)), np.zeros(n), np.zeros(n)

    def predict(self, transition, noise):
        self.mean = transition @ self.mean
        ekf.spread(self.covariance, transition[:N_MOVING], noise**2, self.rows)

    def measure(self, values, deviations):
        """Take in {state: value}."""
        for (k, value), deviation in zip(values.items(), deviations, strict=True):
            total = self.covariance[k, k] + deviation**2
            ekf.find_gain(self.covariance, k, total, True, self.gain)
            self.mean += self.gain * (value - self.mean[k])
            ekf.learn(self.covariance, k, total, self.gain, self.row)
        ekf.make_symmetric(self.covariance)


class KalmanFilter:
    """The textbook's, in full matrices."""

    def __init__(self, mean, covariance):
        self.mean, self.covariance = mean, covariance

    def predict(self, transition, noise):
        self.mean = transition @ self.mean
        self.covariance = transition @ self.covariance @ transition.T + np.diag(noise**2)

    def measure(self, values, deviations):
        rows = np.eye(len(self.mean))[list(values)]
        expected = rows @ self.covariance @ rows.T + np.diag(np.square(deviations))
        gain = self.covariance @ rows.T @ np.linalg.inv(expected)
        self.mean = self.mean + gain @ (np.array(list(values.values())) - rows @ self.mean)
        self.covariance = self.covariance - gain @ rows @ self.covariance
