"""Reports of studies that were swept: whole, with clipped records, unfinished, with few sensors."""

import json

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.execution import InProcessEngine
from hydrofdi.papers import make_report
from hydrofdi.report.detection.report import DetectionReport
from hydrofdi.report.figures import draw_figure
from hydrofdi.store.folder.provenance import write_request
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


CLIPPED = """
name: short
record: {duration: 2 s, sampling_frequency: 500 Hz}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 5, test: 4, shift: 2}
  shifts: {narrow: {pressure_1_sensor.highest: 1 MPa}}
  faults: {leakage.internal_flow: [1 L/min], each: 3, fit: 0}
detection: {indicators: [dwt]}
"""


@pytest.fixture(scope="module")
def clipped(tmp_path_factory):
    folder = tmp_path_factory.mktemp("verdicts")
    (folder / "short.yaml").write_text(CLIPPED)
    out = folder / "out"
    done = run_hydrofdi("sweep", folder / "short.yaml", "--out", out, "--engine", "in-process")
    assert "2 clipped: widen pressure_1_sensor.lowest" in done.stderr
    return out


def test_the_first_page_names_the_verdicts_in_one_line_and_full_the_remedy(clipped):
    lines = run_hydrofdi("report", clipped).stdout.splitlines()
    assert len(lines) <= 15
    assert len([line for line in lines if "2 clipped (R)" in line]) == 1
    assert "widen pressure_1_sensor.lowest" in " ".join(
        run_hydrofdi("report", clipped, "--format", "markdown").stdout.split()
    )


UNFINISHED = """
name: half-study
record: {duration: 2 s}
input: {period: 0.5 s}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}
  healthy: {fit: 30, test: 20}
  faults: {leakage.internal_flow: [0.02 L/min, 2 L/min], each: 15, fit: 5}
detection: {false_alarm_rate: 10 %, probability: 80 %, indicators: [dwt]}
"""
LARGER = ("study.healthy.fit=60", "study.sensitivity.alone=49")


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory):
    """90 runs are stored, and many more are asked for, of a Sobol design none."""
    folder = tmp_path_factory.mktemp("half")
    file = folder / "study.yaml"
    file.write_text(UNFINISHED)
    run_sweep(load_experiment(file), folder / "out", InProcessEngine())
    write_request(folder / "out", load_experiment(file, LARGER))
    return make_report(read_results(folder / "out"))


def test_an_unfinished_study_says_so_first_and_concludes_nothing(unfinished):
    document = unfinished.document()
    (holes,) = [block for block in document.blocks if block.key == "holes"]
    assert holes.tables[0]["Status"].tolist() == ["missing"]
    assert holes.tables[0]["Runs"].tolist() == [unfinished.data.n_run - 90]
    answer = next(block for block in document.blocks if block.key == "answer")
    assert "confidence" not in " ".join(answer.paragraphs)
    assert {"why", "designs"}.isdisjoint(block.key for block in document.blocks)


def test_its_json_counts_what_is_there(unfinished):
    record = unfinished.record()
    assert (record["is_complete"], record["runs_computed"]) == (False, 90)
    (study,) = record["studies"]
    assert sum(each["n"] for each in study["populations"]) == 90
    assert all(one["threshold"]["n"] == 30 for one in record["detection"])


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


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    file = tmp_path_factory.mktemp("sensors") / "study.yaml"
    file.write_text(SENSORS)
    run_sweep(load_experiment(file), file.parent / "out", InProcessEngine())
    return file


def report_with(study, *settings) -> DetectionReport:
    experiment = load_experiment(study, settings)
    run_sweep(experiment, study.parent / "out", InProcessEngine())
    return make_report(read_results(study.parent / "out"))


def test_a_report_says_which_sensors_have_no_noise(study):
    made = report_with(study)
    blocks = {block.key: block for block in made.document().blocks}
    assert made.record()["perfect_sensors"] == ["Ps", "xv"]
    assert "at 8 MPa" in " ".join(blocks["answer"].paragraphs)
    assert 0.5 < made.detections[0].records.per_mean_flow < 5.0
    assert "Ps and xv are simulated without noise" in " ".join(blocks["answer"].paragraphs)


def test_noise_that_is_drawn_is_noise(study):
    made = report_with(study, "study.population.over.spool_sensor.noise={uniform: [0.1 µm, 1 µm]}")
    assert made.record()["perfect_sensors"] == ["Ps"]


def test_scores_that_need_other_sensors_are_left_out(study):
    made = report_with(study, "detection.sensors=[P1, P2, x, u]")
    names = {each.scored.name.partition(".")[0] for each in made.detections[0].judgements}
    assert names == {"dwt"}
    remarks = " ".join(made.detections[0].remarks)
    assert "flow_balance is left out: it needs Ps, xv" in remarks
    assert "the score calm is left out" in remarks


def test_a_run_of_a_study_is_explained(swept):
    done = run_hydrofdi("why", swept.directory, "5", "--json", cwd=swept.folder)
    assert "measurement.seed" in json.loads(done.stdout)["differences"]
    assert run_hydrofdi("why", swept.directory, "5", cwd=swept.folder).returncode == 0
