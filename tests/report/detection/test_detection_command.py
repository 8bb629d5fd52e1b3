"""Reports of studies that were swept: whole, with clipped records, unfinished, with few sensors."""

import shutil
from collections import Counter

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.papers import make_report
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.folder import write_request
from hydrofdi.store.results import read_results
from tests.commands import run_json
from tests.conftest import sweep_in

STUDY = """
name: small-study
store: {signals: pressures}
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa}
study:
  population:
    seed: 3
    over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {normal: [17.2 MPa, 100 kPa]}}
  healthy: {fit: 30, test: 20, shift: 10, confusion: 10}
  faults: {leakage.internal_flow: [0.02 L/min, 2 L/min], each: 15, fit: 5}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
  confusions: {worn friction: {friction.viscous: {uniform: [100, 200]}}}
detection: {false_alarm_rate: 10 %, probability: 80 %, indicators: [dwt, pressure_statistics]}
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("study"), STUDY)


def test_the_json_of_a_study_counts_its_records(swept):
    record = run_json("report", swept.directory)
    (study,) = record["studies"]
    sizes = {(each["population"], each["is_fit"]): each["n"] for each in study["populations"]}
    assert sizes["healthy", True], sizes["healthy", False] == (30, 20)
    names = [one["indicator"] for one in record["detection"]]
    assert {"dwt.d2", "dwt.d3", "pressure_statistics.kurtosis"} <= set(names)
    for one in record["detection"]:
        assert {part["population"] for part in one["false_alarms"]} == {"healthy", "stiffer", "worn friction"}
        assert [part["n"] + part["not_measurable"] for part in one["pod"]] == [15, 15]


def test_records_of_a_study_are_labelled_by_their_population(swept):
    experiment, data = load_experiment(swept.config), read_results(swept.directory)
    for source in (SimulatedRecords(experiment, "study"), StoredRecords(data, "study")):
        labels = Counter(label for batch in source.batches(labels=True) for label in batch.labels)
        assert labels == {
            "healthy": 50, "0.02 L/min": 20, "2 L/min": 20, "shift stiffer": 10,
            "confusion worn friction": 10,
        }  # fmt: skip


def test_an_unfinished_study_says_so_and_concludes_nothing(swept, tmp_path):
    """The runs of a small study are stored, more of them are asked for, and records for nuisances."""
    folder, larger = shutil.copytree(swept.directory, tmp_path / "out"), ("study.healthy.fit=60", ALONE)
    n_run = read_results(folder).n_run
    write_request(folder, load_experiment(swept.config, larger))
    unfinished = make_report(read_results(folder))
    blocks = {block.key: block for block in unfinished.document().blocks}
    (row,) = blocks["holes"].tables[0]
    assert (row["Status"], row["Runs"]) == ("missing", unfinished.data.n_run - n_run)
    assert blocks.keys().isdisjoint({"why", "designs", "train"})
    record = unfinished.record()
    assert (record["is_complete"], record["runs_computed"]) == (False, n_run)
    assert sum(each["n"] for each in record["studies"][0]["populations"]) == n_run
    assert all(one["threshold"]["n"] == 30 for one in record["detection"])


ALONE = "study.sensitivity.alone=49"

SENSORS = """
name: sensors
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa, bias: 1 kPa}
pressure_2_sensor: {noise: 5 kPa}
position_sensor: {noise: 1 µm}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}
  healthy: {fit: 30, test: 30}
  faults: {leakage.internal_flow: [0.2 L/min, 2 L/min], each: 20, fit: 0}
detection:
  false_alarm_rate: 10 %
  probability: 80 %
  indicators: [dwt, flow_balance]
  scores: {calm: {kind: compensated, of: [dwt.d1], by: [flow_balance.leakage]}}
"""


def test_sensors_without_noise_are_named_and_those_left_out_take_their_scores_with_them(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(SENSORS)

    def report_with(*settings):
        run_sweep(load_experiment(file, settings), tmp_path / "out", InProcessEngine())
        return make_report(read_results(tmp_path / "out"))

    made = report_with()
    assert made.record()["perfect_sensors"] == ["Ps", "xv"]
    assert 0.5 < made.detections[0].records.per_mean_flow < 5.0
    fewer = report_with("detection.sensors=[P1, P2, x, u]").detections[0]
    assert {each.scored.name.partition(".")[0] for each in fewer.judgements} == {"dwt"}
    assert sum("is left out" in remark for remark in fewer.remarks) == 2
    drawn = report_with("study.population.over.spool_sensor.noise={uniform: [0.1 µm, 1 µm]}")
    assert drawn.record()["perfect_sensors"] == ["Ps"]
