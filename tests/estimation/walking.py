"""Records of the very model that the filters hold, with its noise, and the filters run on them."""

import numpy as np

from estimation.plants import NOMINAL, SAMPLE, SUPPLY, predicted, spool_paths
from hydrofdi.estimation import ekf_stream
from hydrofdi.estimation.ekf import N_MEASURED
from hydrofdi.estimation.plant import N_STATE
from hydrofdi.estimation.spool_path import spool_transition

N_STEP = 4
N_ESTIMATED = 9
PLACES = np.arange(N_ESTIMATED)
SENSORS = np.array([5e-3, 5e-3, 1e-2]) ** 2
PRIOR = np.zeros(N_STATE)
PRIOR[:N_ESTIMATED] = np.array([5e-3, 5e-3, 1e-2, 1.0, 300.0, 0.3, 0.2, 0.03, 0.03]) ** 2
WALK = np.zeros(N_STATE)
WALK[:N_ESTIMATED] = np.array([1e-3, 1e-3, 1e-4, 0.5, 30.0, 1e-4, 2e-5, 2e-6, 2e-6]) ** 2

TUNING = ekf_stream.Tuning(
    plant=NOMINAL, step=SAMPLE / N_STEP, follows_command=True,
    spool_transition=spool_transition(2.0 * np.pi * 175.0, 0.7, SAMPLE / (2 * N_STEP)),
    prior=PRIOR, walk=WALK, sensors=SENSORS, limits=np.full(N_STATE, 1e6), null_zone=-1.0, largest_travel=1e9,
)  # fmt: skip


def square_wave(n_time, period=1.0, amplitude=2.0):
    """Input voltage."""
    return amplitude * np.where((np.arange(n_time) * SAMPLE) % period < 0.5 * period, 1.0, -1.0)


def records(n_record, n_time, seed):
    """Voltage, true states and measured values: (n_time,), (n_record, n_time, N_STATE), (…, N_MEASURED)."""
    random, voltage = np.random.default_rng(seed), square_wave(n_time)
    paths = spool_paths(voltage)
    states = np.empty((n_record, n_time, N_STATE))
    states[:, 0] = np.sqrt(PRIOR) * random.normal(size=(n_record, N_STATE))
    states[:, 0, :2] += 0.5 * SUPPLY
    for t in range(1, n_time):
        ends, _ = predicted(states[:, t - 1], np.tile(paths[t - 1], (n_record, 1)))
        states[:, t] = ends + np.sqrt(WALK) * random.normal(size=(n_record, N_STATE))
    noise = np.sqrt(SENSORS) * random.normal(size=(n_record, n_time, N_MEASURED))
    return voltage, states, states[:, :, :N_MEASURED] + noise
