"""Records with known answers, for the tests of indicators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch

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
