"""``hydrofdi report`` on a study that was swept."""

import json

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.papers import make_report
from hydrofdi.report.figures import draw_figure
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

STUDY = """
name: small-study
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


def report(swept, *arguments):
    done = run_hydrofdi("report", swept.directory, *arguments, cwd=swept.folder)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_a_study_is_reported_as_one(swept):
    words = " ".join(report(swept, "--full").split())
    assert "fluid.bulk_modulus 440.8 … 661.2 MPa" in words
    assert "supply.pressure 17.2 ± 0.1 MPa (normal)" in words
    assert "fluid.bulk_modulus = 827 MPa" in words
    assert "friction.viscous = 100 … 200 N·s/m" in words


def test_the_first_page_of_a_study_is_a_screen_that_ends_with_the_answer(swept):
    lines = report(swept).splitlines()
    assert len(lines) <= 15
    assert not any(line.endswith(" ") for line in lines)
    assert "more table" in lines[-1]


def test_the_json_of_a_study_counts_its_records(swept):
    record = json.loads(report(swept, "--json"))
    (study,) = record["studies"]
    sizes = {(each["population"], each["is_fit"]): each["n"] for each in study["populations"]}
    assert sizes["healthy", True], sizes["healthy", False] == (30, 20)
    names = [one["indicator"] for one in record["detection"]]
    assert {"dwt.d2", "dwt.d3", "pressure_statistics.kurtosis"} <= set(names)
    for one in record["detection"]:
        assert {part["population"] for part in one["false_alarms"]} == {"healthy", "stiffer", "worn friction"}
        assert [part["n"] + part["not_measurable"] for part in one["pod"]] == [15, 15]


def test_the_signals_are_those_of_a_healthy_and_a_leaking_actuator(swept):
    report = make_report(read_results(swept.directory))
    healthy, leaking = (axis.lines[0].get_ydata() for axis in draw_figure(report, "signals").axes[8:10])
    assert not healthy.any()
    assert leaking.mean() > 0.0


def test_all_forms_of_a_study_are_written(swept, tmp_path):
    run_hydrofdi("report", swept.directory, "--out", tmp_path, cwd=swept.folder)
    written = {path.name for path in tmp_path.iterdir()}
    assert {f"small-study.{form}" for form in ("md", "csv", "json", "html")} <= written
    figures = {"ranking", "pod", "roc", "det", "false_alarms", "densities", "signals"}
    assert {f"{name}.{kind}" for name in figures for kind in ("png", "svg", "pdf")} <= written
