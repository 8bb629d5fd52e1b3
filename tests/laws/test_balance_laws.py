"""The balances of volume and energy close, and notice when something is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.simulation.balances import Trajectory, balance_residuals
from hydrofdi.simulation.batch import simulate_batch

FINE = RunParameters().with_values(
    {"record.step": 2e-5, "record.sampling_frequency": 50e3, "record.duration": 1.0, "input.period": 1.0}
)
RUNS = [FINE, FINE.with_values({"leakage.external_coefficient": 2e-13, "fluid.bulk_modulus": 827e6})]


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return simulate_batch(RUNS, [0.0, 2e-9])


def test_balances_close_at_a_small_step(trajectory: Trajectory) -> None:
    residuals = balance_residuals(RUNS, trajectory)
    assert np.all(residuals.volume < 1e-6)
    assert np.all(residuals.energy < 1e-6)


def test_leakage_that_is_left_out_of_the_account_opens_both_balances(trajectory: Trajectory) -> None:
    forged = replace(trajectory, leakage_coefficient=np.zeros(2))
    residuals = balance_residuals(RUNS, forged)
    assert residuals.volume[1] > 1e-3
    assert residuals.energy[1] > 1e-3


def test_another_friction_opens_the_energy_balance_alone(trajectory: Trajectory) -> None:
    others = [run.with_values({"friction.coulomb": 300.0, "friction.breakaway": 350.0}) for run in RUNS]
    residuals = balance_residuals(others, trajectory)
    assert np.all(residuals.energy > 1e-4)
    assert np.all(residuals.volume < 1e-6)


def test_residuals_of_a_run_do_not_depend_on_the_others(trajectory: Trajectory) -> None:
    alone = balance_residuals(RUNS[1:], simulate_batch(RUNS[1:], [2e-9]))
    together = balance_residuals(RUNS, trajectory)
    assert alone.volume[0] == together.volume[1]
    assert alone.energy[0] == together.energy[1]
