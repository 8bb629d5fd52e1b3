"""Records with known answers, simulated runs, and the laws that indicators keep."""

from dataclasses import replace

import numpy as np

from hydrofdi.config import load_experiment
from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.simulation.batch import simulate_batch

P1, P2 = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE
U = Channel.INPUT_VOLTAGE


def batch(channels, sampling_frequency=500.0, **more):
    """A batch of arrays (n_record, n_time) or (n_time,)."""
    rows = {channel: np.atleast_2d(np.asarray(samples, dtype=float)) for channel, samples in channels.items()}
    ids = tuple(f"r{row}" for row in range(len(next(iter(rows.values())))))
    return RecordBatch(rows, sampling_frequency, ids, **more)


def measured(records, name, **options):
    """Output → numbers of one indicator, and why there are none."""
    measures = measure(records, make_indicators({name: options}))
    values = {key.removeprefix(f"{name}."): value for key, value in measures.values.items()}
    return values, measures.obstacles[name]


def assert_rows_stand_alone(records, name, **options):
    """The numbers of a record are the same to the bit: alone, several times, in any order and layout."""
    together, _ = measured(records, name, **options)
    by_column = {channel: np.asfortranarray(samples) for channel, samples in records.channels.items()}
    for key, value in measured(replace(records, channels=by_column), name, **options)[0].items():
        np.testing.assert_array_equal(together[key], value, err_msg=key)
    for rows in ([0], [records.n_record - 1], [*reversed(range(records.n_record))], [0] * 7):
        apart, _ = measured(records.rows(rows), name, **options)
        for key, value in together.items():
            np.testing.assert_array_equal(value[rows], apart[key], err_msg=key)


def square_wave(n_time, half_period):
    """±2, the first half positive."""
    return np.where(np.arange(n_time) // half_period % 2 == 0, 2.0, -2.0)


def ringing_pressure(n_time, half_period, frequency, damping_ratio, sampling_frequency=500.0):
    """8 MPa ± 1 MPa: a second-order system's answer to a square wave, which starts anew at each step."""
    time = (np.arange(n_time) % half_period) / sampling_frequency
    natural = 2.0 * np.pi * frequency
    rate = natural * np.sqrt(complex(damping_ratio**2 - 1.0))
    decay = np.exp(-damping_ratio * natural * time)
    rings = (
        1.0 - (decay * (np.cosh(rate * time) + damping_ratio * natural * np.sinh(rate * time) / rate)).real
    )
    return 8e6 + 1e6 * square_wave(n_time, half_period) * (rings - 0.5)


SAMPLING_FREQUENCY = 500.0


def records(samples, **more):
    """Records of the chamber-1 pressure."""
    return batch({P1: samples}, SAMPLING_FREQUENCY, **more)


def values(name, samples, **options):
    """Output → numbers (n_record,) of one indicator."""
    numbers, obstacles = measured(_as_records(samples), name, **options)
    assert obstacles == (None,) * len(obstacles)
    return numbers


def _as_records(samples):
    return samples if isinstance(samples, RecordBatch) else records(samples)


def noise(seed, shape, size=1e5, mean=8e6):
    """White noise about a mean pressure [Pa]."""
    return np.random.default_rng(seed).normal(mean, size, shape)


def ringing(seed, n_record, n_time=4000):
    """Pressures that step every second and ring, each record with its own frequency and damping [Pa]."""
    draw = np.random.default_rng(seed)
    time = np.arange(n_time) / SAMPLING_FREQUENCY
    phase = time % 1.0
    frequency, decay = draw.uniform(50, 90, (n_record, 1)), draw.uniform(5, 30, (n_record, 1))
    square = np.where(time % 2.0 < 1.0, 1.0, -1.0)
    motion = square * (1.0 - np.exp(-decay * phase) * np.cos(2 * np.pi * frequency * phase))
    return 8e6 + 2e6 * motion + draw.normal(0, 5e3, (n_record, n_time))


X, XV = Channel.PISTON_POSITION, Channel.SPOOL_POSITION
LEAKS = np.array([0.0, 0.0, 0.0, 1e-9, 5e-9])
MODULI = np.array([551e6, 620e6, 480e6, 551e6, 600e6])


def simulated(*settings, leaks=LEAKS, moduli=MODULI, each=None):
    """Nominal actuators but for K_i [m^3.5/kg^0.5], β [Pa] and settings of each, without noise."""
    parameters = [
        load_experiment(None, [f"fluid.bulk_modulus={modulus} Pa", *settings, *own]).nominal_parameters
        for modulus, own in zip(moduli, each or [()] * len(moduli), strict=True)
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


NOISE = {P1: 5e3, P2: 5e3, X: 10e-6, XV: 0.2e-6, U: 0.0}
"""Standard deviations of sensors: 5 kPa, 10 µm, 0.2 µm of the spool."""


def noisy(records, rows, seed, sizes=NOISE):
    """These rows of runs with noise of their own, and the channels that have a size."""
    draw = np.random.default_rng(seed)
    shape = (len(rows), records.n_time)
    return batch(
        {channel: records[channel][rows] + size * draw.normal(size=shape) for channel, size in sizes.items()}
    )


KNOWN = dict.fromkeys(
    (
        "flow_gain_deviation", "supply_deviation", "offset_deviation", "lap_deviation", "clearance_deviation",
        "pressure_bias", "chamber_volume_deviation", "return_deviation", "free_air_deviation",
        "supply_resistance_deviation", "edge_gain_deviation", "edge_lap_deviation",
    ),
    0.0,
) | {"supply": "nominal"}  # fmt: skip
"""All of a balance but K_i and β."""
