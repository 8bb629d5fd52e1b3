"""The healthy actuator that an experiment is compared with: its own, unless the file says otherwise."""

import json

import pytest

from hydrofdi.config import ExperimentConfig, expand_runs, load_experiment
from hydrofdi.errors import ConfigError

STIFF = "fluid.bulk_modulus=1.2 GPa"
EBM = "sweep.grid.fluid.bulk_modulus=[0.8 GPa, 1.2 GPa, 1.4 GPa]"
FLOW = "sweep.grid.leakage.internal_flow=[0 L/min, 0.5 L/min]"
SEALED = {"leakage.internal_flow": 0.0}


def baseline_of(*settings):
    return load_experiment(None, settings).baseline


def test_the_baseline_is_the_experiments_own_actuator_sealed():
    assert baseline_of(STIFF) == {"fluid.bulk_modulus": 1.2e9} | SEALED
    assert baseline_of() == {"fluid.bulk_modulus": 551e6} | SEALED


def test_a_baseline_given_in_part_is_completed_by_the_experiments_own_actuator():
    given = "baseline.friction.viscous=60"
    assert baseline_of(STIFF, given) == {"fluid.bulk_modulus": 1.2e9, "friction.viscous": 60.0} | SEALED
    sealed = baseline_of(STIFF, "baseline.leakage.internal_coefficient=0")
    assert sealed == {"fluid.bulk_modulus": 1.2e9, "leakage.internal_coefficient": 0.0}
    assert baseline_of(STIFF, "baseline.fluid.bulk_modulus=551 MPa")["fluid.bulk_modulus"] == 551e6


@pytest.mark.parametrize("leak", ["internal_coefficient=1e-9", "internal_flow=0.1 L/min"])
def test_a_baseline_that_leaks_is_a_mistake(leak):
    with pytest.raises(ConfigError, match=r"baseline\.leakage\.internal_.*not a healthy actuator"):
        baseline_of(f"baseline.leakage.{leak}")


def test_where_the_bulk_modulus_is_an_axis_alone_the_baseline_has_that_of_the_model():
    assert baseline_of(EBM)["fluid.bulk_modulus"] == 551e6


def test_runs_are_compared_with_the_own_actuator_and_leaks_are_solved_for_it():
    table = expand_runs(load_experiment(None, [STIFF, EBM, FLOW]))
    leaky = [run for run in table.runs if run.calibration]
    assert len(leaky) == 3
    assert {run.calibration.fluid.bulk_modulus for run in leaky} == {1.2e9}
    (fixed,) = set(table.fixed_baseline)
    assert table.runs[fixed].parameters.fluid.bulk_modulus == 1.2e9
    assert fixed < table.n_swept, "the sweep holds its own healthy run"
    assert table.matched_baseline[fixed] == fixed


def test_a_healthy_actuator_keeps_its_own_external_leakage():
    table = expand_runs(load_experiment(None, ["leakage.external_coefficient=1e-13", FLOW]))
    healthy = table.runs[table.fixed_baseline[-1]].parameters.leakage
    assert (healthy.external_coefficient, healthy.internal_coefficient) == (1e-13, 0.0)


def test_a_stored_request_keeps_the_baseline_that_it_names():
    """A request of earlier versions: stiff fluid, compared with the paper's."""
    stored = json.loads(load_experiment(None, [STIFF]).model_dump_json())
    stored["baseline"] = {"fluid.bulk_modulus": 551e6} | SEALED
    assert ExperimentConfig.model_validate(stored).baseline == stored["baseline"]
