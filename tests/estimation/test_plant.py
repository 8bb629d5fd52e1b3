"""The predicted plant, and the consistency of filters."""

import numpy as np
import pytest
from scipy.stats import chi2

from estimation.filters import UnscentedFilter
from estimation.plants import (
    N_MEASURED,
    NOMINAL,
    PLACES,
    SENSORS,
    TUNING,
    follow_extended,
    follow_unscented,
    predicted,
    records,
    simulated,
    spool_paths,
    square_wave,
    true_states,
)
from hydrofdi.indicators.estimation.plant import (
    N_MOVING,
    N_STATE,
    STATES,
    find_path,
    follow_command,
    spool_transition,
)
from hydrofdi.indicators.estimation.ukf import find_gain, inflate, measurement_update
from tests.machines import LOOP, RIG, settings_of

WITHOUT_FRICTION = ["friction.coulomb=0 N", "friction.breakaway=0 N", "friction.viscous=0 N*s/m"]
LAPPED = ["valve.lap=0.8 um", "valve.lap_leakage=2e-14 m^3/(s*Pa)", "valve.null_offset=0.4 um"]
UNEQUAL = NOMINAL._replace(area_2=500.0, volume_2=200e3)


def smooth_states(n, plant):
    """States and open spools away from the kinks of roots and friction."""
    draw = np.random.default_rng(1)
    states = np.zeros((n, N_STATE))
    states[:, 0], states[:, 1] = draw.uniform(3.0, 5.0, n), draw.uniform(11.0, 13.0, n)
    states[:, 2], states[:, 4] = draw.uniform(-40.0, 40.0, n), draw.normal(0.0, 100.0, n)
    swap = draw.random(n) < 0.5
    states[swap, :2] = states[swap, 1::-1]
    force = plant.area_1 * states[:, 0] - plant.area_2 * states[:, 1]
    states[:, 2] = force / plant.stiffness + draw.normal(0.0, 0.3, n)
    states[:, 3] = draw.choice([-1.0, 1.0], n) * draw.uniform(30.0, 60.0, n)
    states[:, 5], states[:, 6] = draw.uniform(0.0, 1.0, n), draw.normal(0.0, 0.2, n)
    states[:, 7:9] = draw.normal(0.0, 0.03, (n, 2))
    states[:, 9:11] = draw.normal(0.0, 0.6, (n, 2))
    states[:, 11], states[:, 12:] = draw.uniform(0.0, 30.0, n), draw.normal(0.0, 0.05, (n, 2))
    opening = np.copysign(draw.uniform(0.01, 0.04, n), states[:, 3])
    return states, opening[:, None] + np.linspace(0.0, 1e-3, 9)


@pytest.mark.parametrize("plant", [NOMINAL, NOMINAL._replace(has_friction_model=True), UNEQUAL])
def test_the_transition_is_the_slope_of_the_motion(plant):
    states, paths = smooth_states(40, plant)
    _, transitions = predicted(states, paths, plant)
    for name, shift in zip(STATES, 1e-4 * np.eye(N_STATE), strict=True):
        after, before = (predicted(states + sign * shift, paths, plant)[0] for sign in (1.0, -1.0))
        slope = (after - before)[:, :N_MOVING] / 2e-4
        found, atol = transitions[:, :, STATES.index(name)], 1e-6 * np.abs(slope).max(axis=0).max()
        np.testing.assert_allclose(found, slope, rtol=1e-5, atol=atol, err_msg=name)


CLOSED_LOOP = [*settings_of(LOOP), "control.amplitude=20 mm", "input.shape=steps", "input.period=1 s"]
SLOW_FRICTION = ["friction.velocity_threshold=10 mm/s"]


@pytest.mark.parametrize(
    ("machine", "valve", "friction"),
    [
        ([], [], WITHOUT_FRICTION), (settings_of(RIG), LAPPED, SLOW_FRICTION),
        (CLOSED_LOOP, LAPPED, WITHOUT_FRICTION),
    ],
)  # fmt: skip
def test_a_sample_ends_where_the_simulation_has_it(machine, valve, friction):
    leaks = [0.0, 0.5]
    signals = simulated([*machine, "record.duration=3 s", *valve, *friction], leaks)
    plant = NOMINAL._replace(has_friction_model=None if friction is WITHOUT_FRICTION else True)
    for row, states in enumerate(true_states(signals, leaks)):
        states[:, 9], states[:, 10], states[:, 11] = (0.4, 0.8, 20.0) if valve else (0.0, 0.0, 0.0)
        ends, _ = predicted(states[:-1], spool_paths(signals.input_voltage[row])[:-1], plant)
        error = np.abs(ends - states[1:])[:, :N_MOVING]
        assert (error.max(axis=0) < [0.01, 0.01, 1e-3, 0.5]).all()
        assert (np.sqrt((error**2).mean(axis=0)) < [5e-4, 5e-4, 5e-5, 0.03]).all()


@pytest.mark.parametrize("damping_ratio", [0.3, 1.0, 2.0])
def test_the_spool_follows_a_command_as_its_equation_has_it(damping_ratio):
    rate, time, n = 2.0 * np.pi * 175.0, 2e-3, 20000
    transition, path = spool_transition(rate, damping_ratio, time / 8), np.empty(9)
    spool = np.array([0.01, 5.0])
    follow_command(spool, 0.044, transition, path)
    x, v = 0.01, 5.0
    for _ in range(n):
        v += time / n * (rate**2 * (0.044 - x) - 2.0 * damping_ratio * rate * v)
        x += time / n * v
    np.testing.assert_allclose(spool, [x, v], rtol=2e-3, atol=1e-5)
    assert path[0] == 0.01
    assert path[-1] == spool[0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("start", "end", "is_open"), [(5e-3, 9e-3, 1), (5e-3, 11e-3, 0), (1e-3, 5e-3, 0)])
def test_parameters_are_updated_only_while_the_valve_is_open_and_nearly_at_rest(start, end, is_open, sign):
    measured, path = TUNING._replace(follows_command=False), np.empty(9)
    assert find_path(np.zeros(2), sign * start, sign * end, measured, path) == is_open
    np.testing.assert_allclose(path, sign * np.linspace(start, end, 9))


N_RECORD, N_TIME, SETTLED = 24, 1200, 250

FILTERS = pytest.mark.parametrize("follow", [follow_extended, follow_unscented])


def bounds(n_each, n):
    """Range of the mean of n numbers with a chi-square distribution in 99.8 % of all cases."""
    return chi2.ppf([0.001, 0.999], n_each * n) / n


@FILTERS
def test_innovations_errors_and_residuals_are_as_large_as_stated_and_white(follow):
    """Residuals behind an update are the innovations, scaled to the variance R − P."""
    voltage, states, measured = records(N_RECORD, N_TIME, seed=1)
    found = follow(voltage, measured)
    nis = found.nis[:, SETTLED:]
    low, high = bounds(N_MEASURED, nis.size)
    assert low < nis.mean() < high
    error = (found.means - states)[:, -1, PLACES]
    nees = np.einsum("ri,rij,rj->r", error, np.linalg.inv(found.covariance), error)
    low, high = bounds(PLACES.size, N_RECORD)
    assert low < nees.mean() < high
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


def drawn():
    """A mean and a covariance."""
    draw = np.random.default_rng(7)
    factor = draw.normal(size=(N, N))
    return draw.normal(size=N), factor @ factor.T + 0.1 * np.eye(N)


@pytest.mark.parametrize("spread", [1.0, 0.5, 0.03])
def test_a_nonlinear_model_has_the_published_sums(spread):
    def model(points):
        return np.sin(points) + points[::-1] ** 2

    mean, covariance = drawn()
    unscented = UnscentedFilter(mean, covariance, spread)
    unscented.predict(model, np.zeros(N))
    expected_mean, expected_covariance = merwe_moments(mean, covariance, spread, model)
    np.testing.assert_allclose(unscented.mean, expected_mean, rtol=1e-8)
    np.testing.assert_allclose(unscented.covariance, expected_covariance, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("trusted", [5, 3])
def test_a_measurement_with_any_gain_has_joseph_s_covariance(trusted):
    root, gain, variance, k = np.linalg.cholesky(drawn()[1]), np.zeros(N), 0.3, 2
    covariance = root @ root.T
    total = find_gain(root, k, variance, gain)
    assert total == pytest.approx(covariance[k, k] + variance)
    np.testing.assert_allclose(gain, covariance[k] / total, rtol=1e-12)
    error, gain = np.where(np.arange(N) < trusted, 0.0, gain), np.where(np.arange(N) < trusted, gain, 0.0)
    kept = np.eye(N) - np.outer(gain, np.eye(N)[k])
    expected = kept @ covariance @ kept.T + variance * np.outer(gain, gain)
    measurement_update(root, k, variance / total, gain + error)
    inflate(root, np.sqrt(total) * error, np.zeros((N + 2, N)))
    np.testing.assert_allclose(root @ root.T, expected, atol=1e-12)
