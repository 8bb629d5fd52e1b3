"""Spools of several drives, advanced side by side."""

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.simulation.drive import Drive, Spools, input_voltage
from hydrofdi.simulation.kernels.lanes import WIDTH

N_STEP = 400
NOMINAL = RunParameters().with_values({"input.period": 0.04})
RUNS = [
    NOMINAL.with_values({
        "input.amplitude": (2.0, -1.0, 0.5)[k % 3],
        "input.shape": ("square", "sine")[k % 2],
        "valve.natural_frequency": 120.0 + 3.0 * k,
        "valve.largest_opening": (None, 3e-5)[k % 4 == 0],
        "valve.hysteresis": (0.0, 0.1)[k % 5 == 0],
    })
    for k in range(WIDTH + 5)
]  # fmt: skip
DRIVES = [Drive.of(run) for run in RUNS]


def spool_motion(drives):
    """Voltage and stages of each drive, (n_drive, N_STEP, 5), in two chunks."""
    spools = Spools(drives, NOMINAL.record)
    chunks = []
    for first in (0, N_STEP // 2):
        voltage, stages = spools.advance(first, N_STEP // 2)
        chunks.append(np.concatenate([voltage[:, None], stages], axis=1))
    return np.concatenate(chunks).transpose(2, 0, 1)[spools.columns]


@pytest.fixture(scope="module")
def alone():
    return np.concatenate([spool_motion([drive]) for drive in DRIVES])


@pytest.mark.parametrize("n_drive", [2, WIDTH, WIDTH + 5])
def test_a_spool_has_the_same_bits_in_company_of_any_size(alone, n_drive):
    np.testing.assert_array_equal(spool_motion(DRIVES[:n_drive]), alone[:n_drive])


def test_a_spool_has_the_same_bits_in_any_place(alone):
    order = np.random.default_rng(2).permutation(len(DRIVES))
    np.testing.assert_array_equal(spool_motion([DRIVES[k] for k in order]), alone[order])


def test_each_spool_follows_its_own_voltage(alone):
    steps = np.arange(N_STEP)
    expected = [input_voltage(run.input, run.record, steps) for run in RUNS]
    np.testing.assert_allclose(alone[:, :, 0], expected, rtol=1e-15)
    assert np.all(np.abs(alone[4::4, -1, 1]) <= 3e-5)
    assert len({motion.tobytes() for motion in alone}) == len(DRIVES)
