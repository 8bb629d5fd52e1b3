"""The nominal plant of the paper in the units of estimators, and its runs by the simulation."""

from functools import cache

import numpy as np

from hydrofdi.compilation.compiling import dispatcher
from hydrofdi.config import load_experiment
from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE, Plant, follow_command, spool_transition
from hydrofdi.indicators.estimation.prediction import TANGENT_SHAPE, advance_with_transition
from hydrofdi.physics.equation import FAST_MATH
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
