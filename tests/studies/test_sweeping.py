"""Studies through the runner: interruptions, levels that cannot be, and what a detector may see."""

import os
import signal
import time
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.execution.compute import Job, compute_columns, measured_columns
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.report.detection.report import estimates_block
from hydrofdi.store.names import ANALYSIS_ID, LEAKAGE_COEFFICIENT, STATUS
from hydrofdi.store.results import read_results
from hydrofdi.studies.detecting import judge_estimates
from hydrofdi.studies.reading import read_study
from tests.runner.processes import start

STUDY = """
name: small
record: {duration: 2 s}
pressure_1_sensor: {noise: 5 kPa}
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 12, test: 8}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 8, fit: 4}
detection: {false_alarm_rate: 20 %, indicators: [dwt, pressure_statistics, ring_down, flow_balance]}
"""


@pytest.fixture
def study(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY)
    return file


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "study.yaml").write_text(STUDY)
    return swept(folder / "study.yaml", folder / "out")


def swept(file, out, *settings):
    run_sweep(load_experiment(file, settings), out, InProcessEngine())
    return read_results(out)


def test_a_study_that_was_killed_ends_as_one_that_was_not(study, tmp_path):
    study.write_text(STUDY.replace("fit: 12", "fit: 60"))
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    sweep = start("sweep", study, "--out", killed, "--workers", "1")
    limit = time.monotonic() + 240
    while not list(killed.glob("shards/[!.]*.h5")) and sweep.poll() is None and time.monotonic() < limit:
        time.sleep(0.01)
    os.killpg(sweep.pid, signal.SIGKILL)
    sweep.communicate()
    n_stored = len(list(killed.glob("shards/[!.]*.h5")))
    assert n_stored
    assert not (killed / "small.h5").exists()
    swept(study, killed)
    swept(study, whole)
    assert (killed / "small.h5").read_bytes() == (whole / "small.h5").read_bytes()


def test_the_leakage_coefficient_is_that_of_the_level_whatever_is_drawn(stored):
    roles = expand_runs(stored.experiment).study
    coefficients = stored.columns[LEAKAGE_COEFFICIENT]
    of_levels = {
        population.severity: set(coefficients[roles.of_run == number].tolist())
        for number, population in enumerate(roles.populations)
    }
    assert of_levels[0.0] == {0.0}
    assert [len(own) for own in of_levels.values()] == [1, 1, 1]
    assert len({tuple(own) for own in of_levels.values()}) == 3


def test_a_level_that_no_coefficient_reaches_has_no_numbers(study, tmp_path):
    data = swept(study, tmp_path / "out", "study.faults.leakage.internal_flow=[0.2 L/min, 500 L/min]")
    (design,) = read_study(data)
    records = design.records
    lost = [
        row for each in records.populations if each.severity > 1e-3 for row in records.rows(each).tolist()
    ]
    assert len(lost) == 12
    assert set(data.columns[STATUS][lost]) == {"unreachable_leakage"}
    assert np.isnan(records.severity[lost]).all()
    assert all(np.isnan(score.values[lost]).all() for score in design.scores)


def test_standard_errors_and_counts_are_no_scores(stored):
    (design,) = read_study(stored)
    names = {score.name for score in design.scores}
    assert {"ring_down.damping_ratio", "flow_balance.leakage"} <= names
    assert not names & {
        "ring_down.steps",
        "ring_down.frequency_error",
        "flow_balance.condition",
        "flow_balance.lap",
    }


def test_truth_cannot_reach_an_indicator(study):
    """Jobs that claim another leak, another plant and another record measure the same of the same signals."""
    experiment = load_experiment(study, ["detection.indicators=all"])
    runs = expand_runs(experiment).runs.at(range(0, 32, 5))
    honest = [Job.of(run, str(row), 1e-9 * row, f"record {row}") for row, run in enumerate(runs)]
    columns = compute_columns(honest)
    claims = {"leakage.internal_coefficient": 7e-8, "fluid.bulk_modulus": 900e6, "friction.viscous": 400.0}
    poisoned = [
        replace(
            job,
            parameters=job.parameters.with_values(claims),
            leakage_coefficient=7e-8,
            record_id=f"leaks {row} L/min",
        )
        for row, job in enumerate(honest)
    ]
    measured = measured_columns(poisoned, columns)
    outputs = [name for name in measured if "." in name and not name.endswith(ANALYSIS_ID)]
    assert len(outputs) > 80
    for name in outputs:
        if measured[name].dtype == float:
            assert np.array_equal(measured[name], columns[name], equal_nan=True), name
        else:
            assert measured[name].tolist() == columns[name].tolist(), name


def test_each_record_is_transformed_from_its_own_start_phase(study):
    runs = expand_runs(load_experiment(study)).runs.at(range(8))
    jobs = [Job.of(run, str(row), 0.0, f"record {row}") for row, run in enumerate(runs)]
    together = compute_columns(jobs)
    assert len(set(runs.values("wavelet.phase"))) > 4
    for row, job in enumerate(jobs):
        alone = compute_columns([job])
        for name in ("dwt.d1", "dwt.d5", "dwt.a5", "ring_down.frequency", f"dwt{ANALYSIS_ID}"):
            assert together[name][row] == alone[name][0]


ESTIMATES_STUDY = """
name: small
record: {duration: 4 s, sampling_frequency: 500 Hz}
input: {period: 1 s}
pressure_1_sensor: {noise: 5 kPa}
pressure_2_sensor: {noise: 5 kPa}
position_sensor: {noise: 10 µm}
study:
  population: {seed: 3}
  healthy: {fit: 6, test: 12, shift: 5}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 4, fit: 2}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
detection: {false_alarm_rate: 20 %, confidence: 90 %}
indicators: {balance: {kind: flow_balance, spool: command, supply: nominal}, dwt: {}}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("estimates")
    (folder / "study.yaml").write_text(ESTIMATES_STUDY)
    run_sweep(load_experiment(folder / "study.yaml"), folder / "results", InProcessEngine())
    return read_results(folder / "results")


def estimates(data):
    return judge_estimates(data, read_study(data)[0].records)


def judged(data):
    return {(each["quantity"], each["population"]): each for each in estimates(data).rows}


def with_columns(data, **changed):
    return replace(data, columns={**data.columns, **changed})


def test_quantities_with_a_stated_deviation_are_judged_on_test_records_and_shifts(data):
    found = judged(data)
    assert found.keys() == {
        (quantity, population)
        for quantity in ("leakage", "bulk_modulus")
        for population in ("healthy", "stiffer", "faults")
    }
    assert {population: found["bulk_modulus", population]["n"] for _, population in found} == {
        "healthy": 12, "stiffer": 5, "faults": 8,
    }  # fmt: skip


def test_the_truth_with_a_known_error_gives_this_error_and_its_coverage(data):
    truth, n = data.columns["internal_leakage_coefficient"], data.n_run
    draw = np.random.default_rng(5)
    error = 2e-10 + 1e-9 * draw.normal(size=n)
    told = with_columns(
        data,
        **{
            "balance.internal_coefficient": truth + error,
            "balance.internal_coefficient_error": np.full(n, 1e-9),
        },
    )
    faults = judged(told)["leakage", "faults"]
    unit = 1e-9 * np.sqrt(8e6) * 6e4
    assert faults["stated_deviation_L_per_min"] == pytest.approx(unit)
    assert abs(faults["mean_error_L_per_min"]) < 2.0 * unit
    assert 0.1 * unit < faults["deviation_L_per_min"] < 3.0 * unit
    never = with_columns(told, **{"balance.internal_coefficient_error": np.full(n, 1e-15)})
    assert judged(never)["leakage", "faults"]["covered"] == 0.0
    always = with_columns(told, **{"balance.internal_coefficient_error": np.full(n, 1e-3)})
    assert judged(always)["leakage", "faults"]["covered"] == 1.0


def test_bulk_moduli_are_judged_as_shares_of_the_truth(data):
    told = with_columns(data, **{"balance.bulk_modulus": 1.03 * data.columns["bulk_modulus"]})
    for population in ("healthy", "stiffer", "faults"):
        each = judged(told)["bulk_modulus", population]
        assert each["mean_error_percent"] == pytest.approx(3.0)
        assert each["deviation_percent"] < 1e-7


def test_records_without_an_estimate_are_counted_apart(data):
    some = data.columns["balance.bulk_modulus"].copy()
    some[:] = np.nan
    each = judged(with_columns(data, **{"balance.bulk_modulus": some}))["bulk_modulus", "healthy"]
    assert (each["n"], each["not_measurable"], each["covered"]) == (0, 12, None)
    assert each["mean_error_percent"] is None


def test_leaks_that_set_in_later_are_left_out_with_the_reason(data):
    """Neither K_i nor β of such a record has one truth."""
    leakage = data.experiment.leakage.model_copy(update={"onset": "step", "onset_time": 2.0})
    later = replace(data, experiment=data.experiment.model_copy(update={"leakage": leakage}))
    assert {population for _, population in judged(later)} == {"healthy", "stiffer"}
    (sheet,) = estimates_block(estimates(later)).tables
    assert "Faults are left out: leaks set in during the record" in sheet.notes[0]
    (sheet,) = estimates_block(estimates(data)).tables
    assert "left out" not in sheet.notes[0]
