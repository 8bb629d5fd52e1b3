"""Kalman filters on records of their own model: innovations and errors are as large as they state."""

import numpy as np
import pytest
from scipy.stats import chi2

from estimation.walking import (
    N_MEASURED,
    PLACES,
    SENSORS,
    follow_extended,
    follow_unscented,
    records,
    square_wave,
)
from hydrofdi.indicators.estimation.plant import N_STATE

N_RECORD, N_TIME, SETTLED = 24, 1200, 250

FILTERS = pytest.mark.parametrize("follow", [follow_extended, follow_unscented])


@pytest.fixture(scope="module")
def matched():
    """Voltage, true states and measured values."""
    return records(N_RECORD, N_TIME, seed=1)


def bounds(n_each, n):
    """Range of the mean of n numbers with a chi-square distribution in 99.8 % of all cases."""
    return chi2.ppf([0.001, 0.999], n_each * n) / n


@FILTERS
def test_mean_squared_innovations_are_within_their_bounds(follow, matched):
    voltage, _, measured = matched
    nis = follow(voltage, measured).nis[:, SETTLED:]
    low, high = bounds(N_MEASURED, nis.size)
    assert low < nis.mean() < high


@FILTERS
def test_mean_squared_errors_are_within_their_bounds(follow, matched):
    voltage, states, measured = matched
    found = follow(voltage, measured)
    error = (found.means - states)[:, -1, PLACES]
    nees = np.einsum("ri,rij,rj->r", error, np.linalg.inv(found.covariance), error)
    low, high = bounds(PLACES.size, N_RECORD)
    assert low < nees.mean() < high


@FILTERS
def test_residuals_are_white_and_of_the_stated_size(follow, matched):
    """Behind an update they are the innovations, scaled to the variance R − P."""
    voltage, _, measured = matched
    found = follow(voltage, measured)
    size = np.sqrt(SENSORS - found.variances[:, SETTLED:, :N_MEASURED])
    residual = (measured - found.means[:, :, :N_MEASURED])[:, SETTLED:] / size
    few = 4.0 / np.sqrt(residual[:, :, 0].size)
    np.testing.assert_allclose(np.mean(residual**2, axis=(0, 1)), 1.0, atol=1.5 * few)
    for lag in (1, 2, 5, 20):
        together = np.mean(residual[:, lag:] * residual[:, :-lag], axis=(0, 1))
        np.testing.assert_allclose(together, 0.0, atol=few, err_msg=f"lag {lag}")


@FILTERS
@pytest.mark.parametrize("n_time", [100_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_covariances_stay_symmetric_and_positive(follow, n_time):
    voltage = square_wave(n_time)
    draw = np.random.default_rng(2).normal(size=(1, n_time, N_MEASURED))
    _, _, measured = records(1, 500, seed=3)
    measured = np.resize(measured[0], (1, n_time, N_MEASURED)) + np.sqrt(SENSORS) * draw
    found = follow(voltage, measured, every=1000)
    (covariance,) = found.covariance
    assert found.means.shape == (1, n_time // 1000, N_STATE)
    assert np.isfinite(found.means).all()
    np.testing.assert_array_equal(covariance, covariance.T)
    size = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(size, size)).min() > 0.0
