"""Sensors that a study gives its scores, and those that a machine has."""

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.execution import InProcessEngine
from hydrofdi.papers import make_report
from hydrofdi.report.detection.report import DetectionReport
from tests.report.rows import rows

STUDY = """
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


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    file = tmp_path_factory.mktemp("sensors") / "study.yaml"
    file.write_text(STUDY)
    run_sweep(load_experiment(file), file.parent / "out", InProcessEngine())
    return file


def report(study, *settings) -> DetectionReport:
    experiment = load_experiment(study, settings)
    run_sweep(experiment, study.parent / "out", InProcessEngine())
    return make_report(read_results(study.parent / "out"))


def test_a_report_shows_the_sensors_and_says_which_have_no_noise(study):
    made = report(study)
    blocks = {block.key: block for block in made.document().blocks}
    (sheet,) = [sheet for sheet in blocks["populations"].tables if sheet.key == "sensors"]
    shown = {row[0].split()[0]: row[1:] for row in rows(sheet)}
    assert shown["P1"] == ["5 kPa", "1 kPa", "–"]
    assert shown["xv"][0] == shown["Ps"][0] == "none"
    assert made.record()["perfect_sensors"] == ["Ps", "xv"]
    assert "at 8 MPa" in " ".join(blocks["answer"].paragraphs)
    assert 0.5 < made.detections[0].records.per_mean_flow < 5.0
    assert "Ps and xv are simulated without noise" in " ".join(blocks["answer"].paragraphs)


def test_noise_that_is_drawn_is_noise(study):
    made = report(study, "study.population.over.spool_sensor.noise={uniform: [0.1 µm, 1 µm]}")
    assert made.record()["perfect_sensors"] == ["Ps"]


def test_scores_that_need_other_sensors_are_left_out(study):
    made = report(study, "detection.sensors=[P1, P2, x, u]")
    names = {each.scored.name.partition(".")[0] for each in made.detections[0].judgements}
    assert names == {"dwt"}
    remarks = " ".join(made.detections[0].remarks)
    assert "flow_balance is left out: it needs Ps, xv" in remarks
    assert "the score calm is left out" in remarks


def test_a_mistaken_sensor_is_named_with_the_one_that_may_be_meant(study):
    with pytest.raises(ConfigError, match="is unknown; did you mean 'spool_position'"):
        load_experiment(study, ["detection.sensors=[P1, spool_positon]"])
