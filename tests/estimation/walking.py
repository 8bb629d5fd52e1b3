"""Records of the very model that the Kalman filters hold, with its noise, and the filters run on them."""

from typing import NamedTuple

import numpy as np

from estimation.plants import NOMINAL, SAMPLE, SUPPLY, predicted, spool_paths
from hydrofdi.indicators.estimation import ekf_stream, ukf_stream
from hydrofdi.indicators.estimation.ekf_stream import N_MEASURED
from hydrofdi.indicators.estimation.plant import N_STATE, spool_transition
from hydrofdi.indicators.estimation.ukf_stream import Estimated, Workspace

N_STEP = 4
SENSORS = np.array([5e-3, 5e-3, 1e-2]) ** 2
PLACES = np.arange(9)


def variances(*deviations):
    """Of the estimated states; the others are known."""
    return np.pad(np.square(deviations), (0, N_STATE - len(deviations)))


TUNING = ekf_stream.Tuning(
    plant=NOMINAL, step=SAMPLE / N_STEP, follows_command=True,
    spool_transition=spool_transition(2.0 * np.pi * 175.0, 0.7, SAMPLE / (2 * N_STEP)),
    prior=variances(5e-3, 5e-3, 1e-2, 1.0, 100.0, 0.1, 0.03, 0.01, 0.01),
    walk=variances(1e-3, 1e-3, 1e-4, 0.5, 30.0, 1e-4, 2e-5, 2e-6, 2e-6),
    sensors=SENSORS, limits=np.full(N_STATE, 1e6), null_zone=2e-3, largest_travel=5e-3,
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


def _follow(kernel, streams, voltage, measured, *rest, tuning, every):
    n_record, n_time, _ = measured.shape
    means, of_means = (np.zeros((n_record, n_time // every, N_STATE)) for _ in range(2))
    sums = np.zeros((n_record, n_time // every, ekf_stream.N_SUM))
    drive, supply = np.tile(22e-3 * voltage, (n_record, 1)), np.full((n_record, n_time), SUPPLY)
    kernel(streams, 0, measured, drive, supply, tuning, every, means, of_means, sums, *rest)
    return means, of_means, sums[:, :, 0]


def follow_extended(voltage, measured, tuning=TUNING, every=1):
    """By the extended filter."""
    n = len(measured)
    shapes = (N_STATE,), (N_STATE, N_STATE), (N_STATE,), (ekf_stream.N_SUM,), (2,), (2,)
    streams = ekf_stream.Streams(*(np.zeros((n, *shape)) for shape in shapes))
    work = ekf_stream.workspace(N_STEP)
    found = _follow(ekf_stream.follow, streams, voltage, measured, work, tuning=tuning, every=every)
    return Followed(*found, streams.covariance[np.ix_(range(n), PLACES, PLACES)])


def follow_unscented(voltage, measured, tuning=TUNING, every=1):
    """By the unscented filter."""
    streams = ukf_stream.Streams.of(len(measured), PLACES.size)
    estimated = Estimated(PLACES, np.sqrt(tuning.walk[PLACES]), 1.0)
    rest = estimated, Workspace.of(PLACES.size, N_STEP)
    found = _follow(
        ukf_stream.follow_unscented, streams, voltage, measured, *rest, tuning=tuning, every=every
    )
    return Followed(*found, streams.root @ np.swapaxes(streams.root, 1, 2))
