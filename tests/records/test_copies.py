"""Copies of records are found, however they were exported; other records of the same machine are none."""

import numpy as np
import pytest

from hydrofdi.records import RecordBatch
from hydrofdi.records.copies import Copies, sketch_of
from tests.records.measuring import P1, P2, POSITION, VOLTAGE

RATE, N_TIME = 500.0, 4000
TIME = np.arange(N_TIME) / RATE


def machine(seed, digit=1.0, noise=2e4):
    """One drive, with noise of its own, as a converter of a digit [Pa] writes it."""
    rng, drive = np.random.default_rng(seed), np.sin(2.0 * np.pi * 0.7 * TIME)
    pressures = [80e5 + sign * 20e5 * drive + rng.normal(0.0, noise, N_TIME) for sign in (1.0, -1.0)]
    p1, p2 = (digit * np.round(each / digit) for each in pressures)
    position = np.round(0.01 * np.cos(2.0 * np.pi * 0.7 * TIME) + rng.normal(0.0, 1e-6, N_TIME), 7)
    return {P1: p1, P2: p2, POSITION: position, VOLTAGE: np.round(drive, 3)}


def sketch(channels):
    batch = RecordBatch({each: samples[None] for each, samples in channels.items()}, RATE, ("a",))
    return sketch_of(batch, 0)


def rounded(name, samples, digits=(-2, 5)):
    return np.round(samples, digits[name not in (P1, P2)])


COPIES = {
    "equal": lambda _, samples: samples,
    "rounded": rounded,
    "scaled": lambda _, samples: samples * 1.0000001,
    "scaled and printed": lambda name, samples: rounded(name, samples * 1.0000001, (0, 7)),
    "absolute": lambda name, samples: samples + 101_325.0 * (name in (P1, P2)),
    "nine digits": lambda _, samples: np.array([float(f"{value * 1e-5:.9g}") * 1e5 for value in samples]),
    "single precision": lambda _, samples: samples.astype(np.float32).astype(float),
    "without its last samples": lambda _, samples: samples[:-3],
    "one sample later": lambda _, samples: np.concatenate([samples[:1], samples[:-1]]),
    "rounded and without its first sample": lambda name, samples: rounded(name, samples[1:], (-2, 6)),
}


@pytest.mark.parametrize("name", COPIES)
@pytest.mark.parametrize("digit", [1.0, 1e4])
def test_a_copy_is_found(name, digit):
    copies = Copies()
    for seed in (5, 6, 7, 8):
        assert copies.find(sketch(machine(seed, digit))) is None
    copy = {each: COPIES[name](each, samples) for each, samples in machine(7, digit).items()}
    assert copies.find(sketch(copy)) == 2


@pytest.mark.parametrize(("digit", "noise"), [(1.0, 2e4), (1.0, 300.0), (1e4, 2e4), (1e4, 4e3), (5e4, 1e4)])
def test_another_record_of_one_drive_is_no_copy(digit, noise):
    copies = Copies()
    assert {copies.find(sketch(machine(seed, digit, noise))) for seed in range(12)} == {None}


def test_a_record_at_rest_tells_nothing_but_equality():
    copies, rng = Copies(), np.random.default_rng(3)
    for _ in range(5):
        rest = {P1: 80e5 + 1e4 * rng.integers(0, 2, N_TIME), P2: 70e5 + 1e4 * rng.integers(0, 2, N_TIME)}
        assert copies.find(sketch(rest)) is None
    assert copies.find(sketch(rest)) == 4


def test_one_channel_that_differs_makes_another_record():
    copies, one, other = Copies(), machine(1), machine(2)
    assert copies.find(sketch(one)) is None
    assert copies.find(sketch({**one, P2: other[P2]})) is None
    assert copies.known(sketch({**one, VOLTAGE: other[VOLTAGE] + 1.0})) == 0
