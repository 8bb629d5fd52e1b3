"""Noise of healthy and leaking records of one replicate."""

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.simulation.sensing import CHANNELS, CLOCK, random_generator

HEALTHY = RunParameters().with_values({"pressure_1_sensor.noise": 1e4, "measurement.seed": 3})
LEAKING = HEALTHY.with_values({"leakage.internal_coefficient": 1e-8})
SOURCES = [CLOCK, *(channel.section for channel in CHANNELS)]


def draws(run, pairing, source, seed=3):
    paired = run.with_values({"measurement.pairing": pairing, "measurement.seed": seed})
    return random_generator(paired, source).standard_normal(4000)


def test_common_draws_are_the_same_in_all_records_of_a_replicate():
    for source in SOURCES:
        difference = draws(HEALTHY, "common", source) - draws(LEAKING, "common", source)
        assert not difference.any()


def test_another_replicate_or_sensor_draws_its_own():
    first, *others = [draws(HEALTHY, "common", source) for source in SOURCES]
    others.append(draws(HEALTHY, "common", SOURCES[0], seed=4))
    assert max(abs(np.corrcoef(first, other)[0, 1]) for other in others) < 0.06


def test_independent_draws_are_uncorrelated():
    for source in SOURCES:
        pair = (draws(run, "independent", source) for run in (HEALTHY, LEAKING))
        assert abs(np.corrcoef(*pair)[0, 1]) < 0.06


def test_independent_draws_have_kept_their_bits():
    run = RunParameters().with_values(
        {
            "record.duration": 2.0,
            "leakage.internal_coefficient": 1e-8,
            "measurement.seed": 5,
            "pressure_1_sensor.noise": 1e4,
        }
    )
    expected = ["-0x1.2e93fd0789642p+0", "-0x1.e7fee4781c05cp-2", "-0x1.cc58fc617d9adp-3"]
    drawn = random_generator(run, "pressure_1_sensor").standard_normal(3)
    assert [number.hex() for number in drawn.tolist()] == expected
