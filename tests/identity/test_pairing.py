"""Noise of healthy and leaking records of one replicate."""

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.simulation.sensing import CHANNELS, CLOCK, random_generator

NOISY = RunParameters().with_values({"pressure_1_sensor.noise": 1e4})
SOURCES = [CLOCK, *(channel.section for channel in CHANNELS)]


def draws(source, leak, pairing="common", seed=3):
    values = {"leakage.internal_coefficient": leak, "measurement.pairing": pairing, "measurement.seed": seed}
    return random_generator(NOISY.with_values(values), source).standard_normal(4000)


def test_common_draws_are_those_of_the_replicate_and_independent_ones_of_the_record():
    for source in SOURCES:
        assert (draws(source, 0.0) == draws(source, 1e-8)).all()
        pair = [draws(source, leak, "independent") for leak in (0.0, 1e-8)]
        assert abs(np.corrcoef(*pair)[0, 1]) < 0.06
    first, *others = [draws(source, 0.0) for source in SOURCES]
    others.append(draws(SOURCES[0], 0.0, seed=4))
    assert max(abs(np.corrcoef(first, other)[0, 1]) for other in others) < 0.06


def test_independent_draws_have_kept_their_bits():
    values = {"record.duration": 2.0, "leakage.internal_coefficient": 1e-8, "measurement.seed": 5}
    drawn = random_generator(NOISY.with_values(values), "pressure_1_sensor").standard_normal(3)
    expected = ["-0x1.2e93fd0789642p+0", "-0x1.e7fee4781c05cp-2", "-0x1.cc58fc617d9adp-3"]
    assert [number.hex() for number in drawn.tolist()] == expected
