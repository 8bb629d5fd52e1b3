"""Records for tests of indicators, and the laws that all of them keep."""

import numpy as np

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch

SAMPLING_FREQUENCY = 500.0


def records(samples, **more):
    """Records of the chamber-1 pressure."""
    samples = np.atleast_2d(samples)
    ids = tuple(str(row) for row in range(len(samples)))
    return RecordBatch({Channel.CHAMBER_1_PRESSURE: samples}, SAMPLING_FREQUENCY, ids, **more)


def values(name, samples, **options):
    """Output → numbers (n_record,) of one indicator."""
    batch = samples if isinstance(samples, RecordBatch) else records(samples)
    measures = measure(batch, make_indicators({name: options}))
    assert measures.obstacles[name] == (None,) * batch.n_record
    return {key.removeprefix(f"{name}."): array for key, array in measures.values.items()}


def obstacle(name, samples, **options):
    """Why one indicator cannot measure; its numbers are then NaN."""
    measures = measure(records(samples), make_indicators({name: options}))
    assert all(np.isnan(array).all() for array in measures.values.values())
    return measures.obstacles[name][0]


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


def assert_batch_has_no_effect(name, samples, **options):
    """Each record gives the same bits alone, in company, in another order and another layout of memory."""
    together = values(name, samples, **options)
    backwards = values(name, samples[::-1], **options)
    by_column = values(name, np.asfortranarray(samples), **options)
    for key, numbers in together.items():
        np.testing.assert_array_equal(numbers[::-1], backwards[key])
        np.testing.assert_array_equal(numbers, by_column[key])
    for row, record in enumerate(samples):
        alone = values(name, record, **options)
        for key, numbers in together.items():
            np.testing.assert_array_equal(numbers[row : row + 1], alone[key], err_msg=key)


def assert_unit_scales(name, samples, **options):
    """Twice the numbers give twice the outputs in the unit of the channel; the others stay."""
    (indicator,) = make_indicators({name: options}).values()
    one, two = values(name, samples, **options), values(name, 2.0 * samples, **options)
    for output in indicator.outputs:
        factor = 2.0 if output.unit == "Pa" else 1.0
        np.testing.assert_allclose(
            two[output.name], factor * one[output.name], rtol=1e-9, err_msg=output.name
        )
