"""Simulated runs for the tests of observers."""

import numpy as np

from hydrofdi.config import load_experiment
from hydrofdi.records import Channel
from hydrofdi.simulation.batch import simulate_batch
from indicators.signals import P1, P2, U, batch

X, XV = Channel.PISTON_POSITION, Channel.SPOOL_POSITION
LEAKS = np.array([0.0, 0.0, 0.0, 1e-9, 5e-9])
MODULI = np.array([551e6, 620e6, 480e6, 551e6, 600e6])


def simulated(*settings, leaks=LEAKS, moduli=MODULI):
    """Nominal actuators but for K_i [m^3.5/kg^0.5] and β [Pa], without noise."""
    parameters = [
        load_experiment(None, [*settings, f"fluid.bulk_modulus={modulus} Pa"]).nominal_parameters
        for modulus in moduli
    ]
    signals = simulate_batch(parameters, list(leaks))
    return batch(
        {
            P1: signals.chamber_1_pressure,
            P2: signals.chamber_2_pressure,
            X: signals.piston_position,
            XV: signals.spool_position,
            U: signals.input_voltage,
        }
    )


def noisy(records, row, n_record, seed):
    """Copies of a run with sensor noise: 5 kPa, 10 µm, 0.2 µm of the spool."""
    draw = np.random.default_rng(seed)
    sizes = {P1: 5e3, P2: 5e3, X: 10e-6, XV: 0.2e-6, U: 0.0}
    return batch(
        {
            channel: records[channel][row] + size * draw.normal(size=(n_record, records.n_time))
            for channel, size in sizes.items()
        }
    )
