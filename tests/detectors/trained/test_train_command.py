"""``hydrofdi train``: healthy records alone teach, the summary says what the promise rests on."""

import json
import os

import numpy as np
import pytest

from hydrofdi.detectors.file import load_detector
from tests.conftest import sweep_in
from tests.records.measuring import csv_of

HEADER = "time [s],P1 [bar],P2 [bar],u [V]"


def write_record(path, seed, leak=0.0, n_sample=400):
    """A measured file: pressures of a motion with noise, their swing smaller where it leaks."""
    draw = np.random.default_rng(seed)
    time = np.arange(n_sample) / 100.0
    swing = (1.0 - leak) * np.sin(2.0 * np.pi * time)
    p1, p2 = (80.0 + sign * 20.0 * swing + 0.2 * draw.standard_normal(n_sample) for sign in (1.0, -1.0))
    path.parent.mkdir(exist_ok=True)
    path.write_text(csv_of(*zip(HEADER.split(","), (time, p1, p2, np.sign(swing)), strict=True)))


MEASURED = """\
files: "runs/*.csv"
time: {column: "time [s]"}
channels: {chamber_1_pressure: "P1 [bar]", chamber_2_pressure: "P2 [bar]", input_voltage: "u [V]"}
path: "day {day} {condition} {run}.csv"
group: "{day}"
label: "{condition}"
"""


@pytest.fixture
def measured(tmp_path):
    """Three days with ten sound runs each, worn ones, one of a kind that nobody named."""
    for day in range(3):
        for run in range(10):
            write_record(tmp_path / f"runs/day {day} sound {run}.csv", seed=100 * day + run)
        for run in range(4):
            write_record(tmp_path / f"runs/day {day} worn {run}.csv", seed=100 * day + 50 + run, leak=0.5)
    (tmp_path / "measured.yaml").write_text(MEASURED)
    return tmp_path


DETECTOR = ["--indicator", "pressure_statistics", "--output", "standard_deviation", "--direction", "falling"]
TRAIN = [*DETECTOR, "--false-alarm-rate", "10 %", "--out", "detector.json"]


def test_labelled_records_teach_where_their_label_is_healthy(hydrofdi, measured):
    for healthy in ((), ("--healthy", "soud")):
        refused = hydrofdi("train", "measured.yaml", *TRAIN, *healthy)
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    done = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "sound", "--window", "1 s")
    assert done.returncode == 0, done.stderr
    file = load_detector(measured / "detector.json")
    assert file.basis.populations == {"sound": 120}
    assert (file.basis.n_record, file.basis.n_group) == (30, 3)
    assert file.limits.interval_rests_on == "groups"
    assert file.limits.high is None
    assert file.channels == ("chamber_1_pressure",)
    assert "360 false alarms an hour" in " ".join(done.stdout.split())


def test_records_that_repeat_the_samples_of_another_teach_once(hydrofdi, measured):
    (measured / "runs/day 1 sound 10.csv").write_bytes((measured / "runs/day 1 sound 9.csv").read_bytes())
    (measured / "runs/day 1 sound 11.csv").write_text(HEADER + "\n")
    done = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "sound", "--json")
    assert done.returncode == 1
    told = json.loads(done.stdout)
    assert told["detector"]["basis"]["n_record"] == 30
    assert (told["left_out"]["n_repeated"], told["left_out"]["n_rejected"]) == (1, 1)
    assert "day 1 sound 9.csv" in done.stderr


def test_of_a_sweep_the_runs_without_a_leak_teach(hydrofdi, tmp_path):
    text = """\
name: sealed
record: {duration: 2 s}
store: {signals: pressures}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-8]
    leakage.external_coefficient: [0, 1e-12]
    fluid.bulk_modulus: [500 MPa, 520 MPa, 540 MPa, 560 MPa, 580 MPa, 600 MPa, 620 MPa, 640 MPa, 660 MPa]
"""
    swept = sweep_in(tmp_path, text)
    files = []
    for source in (swept.directory, "experiment.yaml"):
        done = hydrofdi("train", source, *TRAIN, "--json")
        assert done.returncode == 0, done.stderr
        told = json.loads(done.stdout)
        assert told["left_out"]["n_leaking"] == 28
        assert told["detector"]["basis"]["n_record"] == 10
        assert all(label.startswith("sealed") for label in told["detector"]["basis"]["populations"])
        files.append(load_detector(tmp_path / "detector.json"))
    assert files[0].limits == files[1].limits


def test_of_a_study_the_healthy_fit_records_alone_teach(hydrofdi, tmp_path):
    (tmp_path / "study.yaml").write_text(
        """\
name: study
record: {duration: 2 s}
study:
  population: {over: {fluid.bulk_modulus: {normal: ±5 %}}}
  healthy: {fit: 12, test: 3}
  faults: {leakage.internal_coefficient: [1e-8], each: 2, fit: 0}
  shifts: {stiffer: {fluid.bulk_modulus: 700 MPa}}
"""
    )
    done = hydrofdi("train", "study.yaml", *TRAIN, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["detector"]["basis"]["populations"] == {"healthy (fit)": 12}
    assert told["left_out"]["n_leaking"] == 8


def test_settings_come_from_a_file_and_options_win(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    (tmp_path / "base.yaml").write_text("window: {duration: 2 s}\ndirection: both\n")
    (tmp_path / "mine.yaml").write_text(
        "extends: base.yaml\n"
        "indicators: {swing: {kind: pressure_statistics, channel: chamber_2_pressure}}\n"
        "output: peak_to_peak\n"
        "false_alarm_rate: 20 %\n"
        "chart: {chart: ewma, false_alarm_every: 10 s}\n"
    )
    done = hydrofdi("train", "run.csv", "--config", "mine.yaml", "--window", "1 s", "--out", "detector.json")
    assert done.returncode == 0, done.stderr
    file = load_detector(tmp_path / "detector.json")
    assert file.config.options == {"channel": "chamber_2_pressure"}
    assert (file.config.window.duration, file.config.direction) == (1.0, "both")
    assert file.limits.false_alarm_rate == 0.2
    assert file.config.chart.options == {"direction": "both", "weight": 0.1, "variance": "exact"}
    (tmp_path / "wrong.yaml").write_text("extends: base.yaml\nindicatr: dwt\nchart: {chart: cusm}\n")
    refused = hydrofdi("train", "run.csv", "--config", "wrong.yaml", "--every", "1 bar", "--out", "x.json")
    assert refused.returncode == 2
    assert "hydrofdi: wrong.yaml:2: indicatr" in refused.stderr
    assert "hydrofdi: every: " in refused.stderr


def test_a_chart_keeps_a_stated_time_between_false_alarms_if_the_hours_carry_it(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    asked = "train", "run.csv", *DETECTOR, *TRAIN[-2:], "--window", "1 s", "--false-alarm-every"
    done = hydrofdi(*asked, "10 s", "--chart", "ewma")
    assert done.returncode == 0, done.stderr
    file = load_detector(tmp_path / "detector.json")
    assert (file.config.chart.chart, file.config.chart.false_alarm_every) == ("ewma", 10.0)
    told = " ".join(done.stdout.split())
    assert "set for one false alarm in 10 s" in told
    assert "Designed for" not in told
    refused = hydrofdi(*asked, "30 days")
    assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    assert "needs 720 h" in refused.stderr


def test_only_a_detector_or_nothing_stands_where_a_detector_is_written_and_a_link_stays(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    before = (tmp_path / "run.csv").read_bytes()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty.json").touch()
    (tmp_path / "link").symlink_to("pipe")
    for out in ("pipe", "link", ".", "empty.json", "absent/x.json", "run.csv"):
        refused = hydrofdi("train", "run.csv", *TRAIN[:-1], out, "--window", "1 s")
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
    assert (tmp_path / "pipe").is_fifo()
    assert not (tmp_path / "absent").exists()
    assert (tmp_path / "empty.json").read_bytes() == b""
    assert (tmp_path / "run.csv").read_bytes() == before
    (tmp_path / "detector.json").symlink_to("target.json")
    for _ in range(2):
        done = hydrofdi("train", "run.csv", *TRAIN, "--window", "1 s", "--every", "0.5 s")
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "detector.json").is_symlink()
    assert load_detector(tmp_path / "target.json").limits.interval_rests_on == "windows"


def test_what_one_record_does_not_carry_is_refused(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    for arguments in (
        [*DETECTOR, "--window", "1 s", "--out", "detector.json"],
        [*TRAIN, "--window", "50 s"],
        [*TRAIN, "--healthy", "sound"],
        [*TRAIN, "--false-alarm-rate", "1e-300"],
    ):
        refused = hydrofdi("train", "run.csv", *arguments)
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
