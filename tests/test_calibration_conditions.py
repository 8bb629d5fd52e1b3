"""For which actuator a leakage flow is turned into K_i."""
# ruff: noqa: E501

import h5py
import pytest

from hydrofdi.config import expand_runs, load_experiment
from tests import commands

FLOWS = "sweep.grid.leakage.internal_flow=[0 L/min, 0.12 L/min, 0.5 L/min]"
DRAWN = "sweep.sample={count: 16, over: {friction.viscous: {uniform: [40, 60]}, actuator.mass: {uniform: [9, 15]}}}"
NOMINAL = "calibration.at=nominal"


def runs_of(*settings):
    return expand_runs(load_experiment(None, settings)).runs


def test_each_run_is_solved_for_its_own_actuator_by_default():
    runs = runs_of(FLOWS, DRAWN)
    assert vars(runs.solutions()) == {"flows": 2, "conditions": 16, "total": 32}
    for run in runs:
        if run.calibration:
            assert run.calibration.friction == run.parameters.friction


def test_at_the_nominal_actuator_each_flow_is_solved_once():
    experiment = load_experiment(None, [FLOWS, DRAWN, NOMINAL, "baseline.supply.pressure=17 MPa"])
    runs = expand_runs(experiment).runs
    assert vars(runs.solutions()) == {"flows": 2, "conditions": 1, "total": 2}
    nominal = experiment.nominal_parameters
    leaky = [run for run in runs if run.calibration]
    assert len(leaky) == 32
    for run in leaky:
        assert run.calibration.leakage.internal_flow == run.parameters.leakage.internal_flow
        assert run.calibration.friction == nominal.friction
        assert run.calibration.actuator == nominal.actuator
        assert run.calibration.supply.pressure == 17e6


def test_nominal_calibrations_leave_all_but_the_flow_at_the_nominal_actuator():
    laws = "sweep.zip.leakage.law=[orifice, laminar]"
    for run in runs_of(FLOWS, laws, NOMINAL):
        if run.calibration:
            assert run.calibration.leakage.law == "orifice"


def test_every_scenario_has_its_own_nominal_actuator():
    runs = runs_of(FLOWS, DRAWN, NOMINAL, "ensemble.grid.supply.pressure=[16 MPa, 18 MPa]")
    assert vars(runs.solutions()) == {"flows": 2, "conditions": 2, "total": 4}
    for run in runs:
        if run.calibration:
            assert run.calibration.supply == run.parameters.supply


def test_a_leaky_baseline_is_solved_under_the_same_conditions():
    """Files refuse such a baseline; results of earlier versions may have it."""
    experiment = load_experiment(None, [DRAWN, NOMINAL])
    leaky = experiment.baseline | {"leakage.internal_flow": 1e-6}
    table = expand_runs(experiment.model_copy(update={"baseline": leaky}))
    assert vars(table.runs.solutions()) == {"flows": 1, "conditions": 1, "total": 1}
    healthy = table.runs[int(table.matched_baseline[3])]
    assert healthy.parameters.friction == table.runs[3].parameters.friction
    assert healthy.calibration.friction != healthy.parameters.friction


def test_conditions_that_do_not_multiply_are_counted_all_the_same():
    union = "sweep.union=[{grid: {leakage.internal_flow: [1e-6], friction.viscous: [50, 60]}}, {grid: {leakage.internal_flow: [2e-6]}}]"
    assert vars(runs_of(union).solutions()) == {"flows": 2, "conditions": 2, "total": 3}


def test_a_nominal_coefficient_is_shared_and_flows_differ(tmp_path, experiment_file):
    file = experiment_file(
        "name: drawn\nrecord: {duration: 2 s}\ncalibration: {at: nominal}\nstore: {signals: none}\n"
        "sweep: {grid: {leakage.internal_flow: [0.5 L/min], supply.pressure: [10 MPa, 17.2 MPa]}}\n"
    )
    commands.run("sweep", file, "--workers", "1", check=0, cwd=tmp_path)
    rows = [
        row
        for row in commands.run_json("report", cwd=tmp_path)["rows"]
        if row["internal_leakage_coefficient"]
    ]
    assert len({row["internal_leakage_coefficient"] for row in rows}) == 1
    with h5py.File(tmp_path / "results" / "drawn" / "drawn.h5") as stored:
        flows = stored["mean_internal_leakage_flow"][:2] * 60e3
    assert flows[1] == pytest.approx(0.5, rel=1e-3)
    assert flows[0] < 0.45


@pytest.mark.parametrize(("at", "total"), [("run", 32), ("nominal", 2)])
def test_a_plan_counts_the_solutions(tmp_path, experiment_file, at, total):
    file = experiment_file("name: drawn\nrecord: {duration: 2 s}\n")
    settings = [part for setting in (FLOWS, DRAWN, f"calibration.at={at}") for part in ("--set", setting)]
    assert commands.run_json("plan", file, *settings, cwd=tmp_path)["solutions"]["total"] == total
