"""Records for tests of indicators, and the laws that all of them keep."""

import numpy as np

from hydrofdi.records import RecordBatch
from indicators.signals import P1, batch, measured

SAMPLING_FREQUENCY = 500.0


def records(samples, **more):
    """Records of the chamber-1 pressure."""
    return batch({P1: samples}, SAMPLING_FREQUENCY, **more)


def values(name, samples, **options):
    """Output → numbers (n_record,) of one indicator."""
    numbers, obstacles = measured(_as_records(samples), name, **options)
    assert obstacles == (None,) * len(obstacles)
    return numbers


def obstacle(name, samples, **options):
    """Why one indicator cannot measure; its numbers are then NaN."""
    numbers, (reason,) = measured(_as_records(samples), name, **options)
    assert all(np.isnan(array).all() for array in numbers.values())
    return reason


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
