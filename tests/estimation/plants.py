"""The nominal plant of the paper in the units of estimators, its runs and records, and filters on them."""

from functools import cache
from typing import NamedTuple

import numpy as np

from hydrofdi.compilation.object_code import dispatcher
from hydrofdi.config import load_experiment
from hydrofdi.indicators.estimation import ekf, ukf
from hydrofdi.indicators.estimation.ekf import TANGENT_SHAPE, advance_with_transition
from hydrofdi.indicators.estimation.plant import (
    N_MEASURED,
    N_MOVING,
    N_STATE,
    Plant,
    Tuning,
    follow_command,
    spool_transition,
)
from hydrofdi.indicators.kalman_filter import N_SUM, follow, new_streams
from hydrofdi.physics import FAST_MATH
from hydrofdi.simulation.batch import simulate_batch

NOMINAL = Plant(
    mass=0.0123, area_1=633.0, area_2=633.0, volume_1=280e3, volume_2=280e3, stiffness=150.0,
    bulk_modulus=551.0, ret=0.0, reference_pressure=8.0, flow_gain=29200.0, area_gradient=20.75,
    coulomb=200.0, breakaway=250.0, viscous=0.05, transition=0.04, velocity_threshold=10.0,
    has_friction_model=None,
)  # fmt: skip
SUPPLY = 17.2
SAMPLE, N_STEP = 2e-3, 4
PER_LITRE_PER_MINUTE = 1e-3 / 60.0 / np.sqrt(8e6)
"""K_i of a leak of 1 L/min at 8 MPa [m^3.5/kg^0.5]."""


@cache
def advancing():
    """`advance_with_transition`, compiled as within the filter."""
    return dispatcher(lambda *given: advance_with_transition(*given), fastmath=FAST_MATH)


def predicted(states, paths, plant=NOMINAL, supply=SUPPLY):
    """States a sample later, and the transitions."""
    ends, transitions = np.array(states), np.empty((len(states), N_MOVING, N_STATE))
    step, tangents = SAMPLE / (paths.shape[1] // 2), np.empty(TANGENT_SHAPE)
    for end, path, transition in zip(ends, np.ascontiguousarray(paths), transitions, strict=True):
        advancing()(end, path, step, supply, plant, transition, tangents)
    return ends, transitions


def simulated(settings, leaks):
    """Runs of the simulation for leaks in L/min."""
    parameters = load_experiment(None, settings).nominal_parameters
    return simulate_batch([parameters] * len(leaks), [PER_LITRE_PER_MINUTE * leak for leak in leaks])


def true_states(signals, leaks):
    """The states of all samples of the runs, (n_run, n_time, N_STATE)."""
    states = np.zeros((*signals.chamber_1_pressure.shape, N_STATE))
    states[..., 0], states[..., 1] = 1e-6 * signals.chamber_1_pressure, 1e-6 * signals.chamber_2_pressure
    states[..., 2], states[..., 3] = 1e3 * signals.piston_position, 1e3 * signals.piston_velocity
    states[..., 5] = np.asarray(leaks)[:, None]
    return states


def spool_paths(voltage):
    """Path of the spool over each sample of a run under its command, (n_time, 2 N_STEP + 1)."""
    paths, spool = np.empty((len(voltage), 2 * N_STEP + 1)), np.zeros(2)
    transition = spool_transition(2.0 * np.pi * 175.0, 0.7, SAMPLE / (2 * N_STEP))
    for path, u in zip(paths, voltage, strict=True):
        follow_command(spool, 22e-3 * u, transition, path)
    return paths


SENSORS = np.array([5e-3, 5e-3, 1e-2]) ** 2
PLACES = np.arange(9)


def variances(*deviations):
    """Of the estimated states; the others are known."""
    return np.pad(np.square(deviations), (0, N_STATE - len(deviations)))


TUNING = Tuning(
    plant=NOMINAL, step=SAMPLE / N_STEP, follows_command=True,
    spool_transition=spool_transition(2.0 * np.pi * 175.0, 0.7, SAMPLE / (2 * N_STEP)),
    prior=variances(5e-3, 5e-3, 1e-2, 1.0, 100.0, 0.1, 0.03, 0.01, 0.01),
    walk=variances(1e-3, 1e-3, 1e-4, 0.5, 30.0, 1e-4, 2e-5, 2e-6, 2e-6),
    sensors=SENSORS, limits=np.full(N_STATE, 1e6), places=np.arange(N_STATE),
    null_zone=2e-3, largest_travel=5e-3,
)  # fmt: skip


def square_wave(n_time, period=1.0, amplitude=2.0):
    """Input voltage, behind a first sample with the spool at rest in its centre."""
    voltage = amplitude * np.where((np.arange(n_time) * SAMPLE) % period < 0.5 * period, 1.0, -1.0)
    voltage[0] = 0.0
    return voltage


def records(n_record, n_time, seed):
    """Voltage, true states and measured values: (n_time,), (n_record, n_time, N_STATE), (…, N_MEASURED)."""
    random, voltage = np.random.default_rng(seed), square_wave(n_time)
    paths, n_each = spool_paths(voltage), (n_record, N_STATE)
    states = np.empty((n_record, n_time, N_STATE))
    states[:, 0] = np.sqrt(TUNING.prior) * random.normal(size=n_each)
    states[:, 0, :2] += 0.5 * SUPPLY
    for t in range(1, n_time):
        ends, _ = predicted(states[:, t - 1], np.tile(paths[t - 1], (n_record, 1)))
        states[:, t] = ends + np.sqrt(TUNING.walk) * random.normal(size=n_each)
    noise = np.sqrt(SENSORS) * random.normal(size=(n_record, n_time, N_MEASURED))
    return voltage, states, states[:, :, :N_MEASURED] + noise


class Followed(NamedTuple):
    """Estimates of each sample, their squared innovations over variances, and the last covariances."""

    means: np.ndarray
    variances: np.ndarray
    nis: np.ndarray
    covariance: np.ndarray


def _follow(voltage, measured, *rest, tuning, every):
    n_record, n_time, _ = measured.shape
    streams = new_streams(n_record, tuning.places.size)
    means, of_means = (np.zeros((n_record, n_time // every, N_STATE)) for _ in range(2))
    sums = np.zeros((n_record, n_time // every, N_SUM))
    drive, supply = np.tile(22e-3 * voltage, (n_record, 1)), np.full((n_record, n_time), SUPPLY)
    follow(streams, measured, drive, supply, tuning, every, means, of_means, sums, *rest)
    return Followed(means, of_means, sums[:, :, 0], streams.covariance)


def follow_extended(voltage, measured, tuning=TUNING, every=1):
    """By the extended filter."""
    rest = np.zeros((len(measured), N_STATE)), None, ekf.workspace(N_STEP)
    found = _follow(voltage, measured, *rest, tuning=tuning, every=every)
    return found._replace(covariance=found.covariance[:, : PLACES.size, : PLACES.size])


def follow_unscented(voltage, measured, tuning=TUNING, every=1):
    """By the unscented filter."""
    rest, tuning = (None, 1.0, ukf.workspace(PLACES.size, N_STEP)), tuning.of_roots(PLACES)
    found = _follow(voltage, measured, *rest, tuning=tuning, every=every)
    return found._replace(covariance=found.covariance @ np.swapaxes(found.covariance, 1, 2))
