"""The hydraulic part of the model, started from any state, with the valve held."""

import itertools
import math

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.simulation.kernel import advance_lanes
from hydrofdi.simulation.lanes import SAMPLED, STATES, WIDTH, ModelOptions, pack_lanes
from tests.machines import RIG

FRICTIONLESS = {"friction.coulomb": 0.0, "friction.breakaway": 0.0, "friction.viscous": 0.0}
FREE = {"actuator.load_stiffness": 0.0}
HELD = {"actuator.mass": 1e18}
"""A piston so heavy that it does not move."""


def free_motion(values, start, spool, duration, step, machine=RIG):
    """States at every step, each (n_run, n_step), of runs whose spools stand still where they are put."""
    runs = [RunParameters().with_values(machine | changes) for changes in values]
    (options,) = {ModelOptions.of(run) for run in runs}
    lanes = pack_lanes(runs, [run.leakage.internal_coefficient or 0.0 for run in runs])
    for lane, state in enumerate(start):
        half, k = ("left", lane) if lane < WIDTH // 2 else ("right", lane - WIDTH // 2)
        for name, value in state.items():
            lanes[half][name][0, k] = value
    n_step = round(duration / step)
    stages = np.broadcast_to(np.asarray(spool, dtype=float), (n_step, 4, len(spool))).copy()
    samples = np.empty((n_step, len(SAMPLED), WIDTH))
    drives, loads = np.resize(np.arange(len(spool)), WIDTH), np.zeros((n_step, 1))
    shared = int(len(spool) == 1)
    advance_lanes(
        lanes, stages, drives, loads, np.zeros(WIDTH, int), shared, float(step), 1, 1, samples, 0, options
    )  # fmt: skip
    return {name: samples[:, row, : len(runs)].T.copy() for row, name in enumerate(STATES)}


def ring_down(velocity, step):
    """ω [rad/s] and ζ, from upward zero crossings and the peaks between them."""
    before = np.flatnonzero((velocity[:-1] <= 0.0) & (velocity[1:] > 0.0))
    crossings = step * (before - velocity[before] / (velocity[before + 1] - velocity[before]))
    peaks = [velocity[a : b + 1].max() for a, b in itertools.pairwise(before)]
    damped = 2.0 * math.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    decay = math.log(peaks[0] / peaks[-1]) * damped / (2.0 * math.pi * (len(peaks) - 1))
    omega = math.hypot(damped, decay)
    return omega, decay / omega
