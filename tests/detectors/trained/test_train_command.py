"""``hydrofdi train``: healthy records alone teach, the summary says what the promise rests on."""

import json
import os

import numpy as np

from hydrofdi.detectors.file import load_detector
from tests.conftest import sweep_in
from tests.records.measuring import csv_of

HEADER = "time [s],P1 [bar],P2 [bar],u [V]"


def write_record(path, seed, leak=0.0, n_sample=400):
    """A measured file: pressures of a motion with noise, their swing smaller where it leaks."""
    draw, time = np.random.default_rng(seed), np.arange(n_sample) / 100.0
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
DETECTOR = ["--indicator", "pressure_statistics", "--output", "standard_deviation", "--direction", "falling"]
TRAIN = [*DETECTOR, "--false-alarm-rate", "10 %", "--out", "detector.json"]


def refused(hydrofdi, *arguments):
    done = hydrofdi("train", *arguments)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    return done.stderr


def told(hydrofdi, *arguments, code=0):
    done = hydrofdi("train", *arguments, "--json")
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


def test_labelled_records_teach_once_where_their_label_is_healthy(hydrofdi, tmp_path):
    for day in range(3):
        for run in range(10):
            write_record(tmp_path / f"runs/day {day} sound {run}.csv", seed=100 * day + run)
        write_record(tmp_path / f"runs/day {day} worn 0.csv", seed=100 * day + 50, leak=0.5)
    (tmp_path / "measured.yaml").write_text(MEASURED)
    for healthy in ((), ("--healthy", "soud")):
        refused(hydrofdi, "measured.yaml", *TRAIN, *healthy)
    done = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "sound", "--window", "1 s")
    assert done.returncode == 0, done.stderr
    file = load_detector(tmp_path / "detector.json")
    assert (file.basis.populations, file.basis.n_record, file.basis.n_group) == ({"sound": 120}, 30, 3)
    assert (file.limits.interval_rests_on, file.limits.high) == ("groups", None)
    assert file.channels == ("chamber_1_pressure",)
    (tmp_path / "runs/day 1 sound 10.csv").write_bytes((tmp_path / "runs/day 1 sound 9.csv").read_bytes())
    (tmp_path / "runs/day 1 sound 11.csv").write_text(HEADER + "\n")
    found = told(hydrofdi, "measured.yaml", *TRAIN, "--healthy", "sound", code=1)
    assert found["detector"]["basis"]["n_record"] == 30
    left = found["left_out"]
    assert (left["n_leaking"], left["n_repeated"], left["n_rejected"]) == (3, 1, 1)
    assert "day 1 sound 9.csv" in left["repeats"][0]


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
        found = told(hydrofdi, source, *TRAIN)
        assert (found["left_out"]["n_leaking"], found["detector"]["basis"]["n_record"]) == (28, 10)
        assert all(label.startswith("sealed") for label in found["detector"]["basis"]["populations"])
        files.append(load_detector(tmp_path / "detector.json"))
    assert files[0].limits == files[1].limits


def test_of_a_study_the_healthy_fit_records_alone_teach(hydrofdi, tmp_path):
    study = {
        "population": {"over": {"fluid.bulk_modulus": {"normal": "±5 %"}}},
        "healthy": {"fit": 12, "test": 3},
        "faults": {"leakage.internal_coefficient": [1e-8], "each": 2, "fit": 0},
        "shifts": {"stiffer": {"fluid.bulk_modulus": "700 MPa"}},
    }
    (tmp_path / "study.yaml").write_text(json.dumps({"record": {"duration": "2 s"}, "study": study}))
    found = told(hydrofdi, "study.yaml", *TRAIN)
    assert found["detector"]["basis"]["populations"] == {"healthy (fit)": 12}
    assert found["left_out"]["n_leaking"] == 8


def test_settings_come_from_a_file_and_options_win(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    (tmp_path / "base.yaml").write_text("window: {duration: 2 s}\ndirection: both\n")
    (tmp_path / "mine.yaml").write_text(
        "extends: base.yaml\n"
        "indicators: {swing: {kind: pressure_statistics, channel: chamber_2_pressure}}\n"
        "output: peak_to_peak\nfalse_alarm_rate: 20 %\nchart: {chart: ewma, false_alarm_every: 10 s}\n"
    )
    mine = "run.csv", "--config", "mine.yaml", "--window", "1 s", "--out", "detector.json"
    done = hydrofdi("train", *mine)
    assert done.returncode == 0, done.stderr
    file = load_detector(tmp_path / "detector.json")
    assert file.config.options == {"channel": "chamber_2_pressure"}
    assert (file.config.window.duration, file.config.direction) == (1.0, "both")
    assert file.limits.false_alarm_rate == 0.2
    assert file.config.chart.options == {"direction": "both", "weight": 0.1, "variance": "exact"}
    assert "needs 720 h" in refused(hydrofdi, *mine, "--false-alarm-every", "30 days")
    (tmp_path / "wrong.yaml").write_text("extends: base.yaml\nindicatr: dwt\nchart: {chart: cusm}\n")
    wrong = hydrofdi("train", "run.csv", "--config", "wrong.yaml", "--every", "1 bar", "--out", "x.json")
    assert wrong.returncode == 2
    assert "hydrofdi: wrong.yaml:2: indicatr" in wrong.stderr
    assert "hydrofdi: every: " in wrong.stderr


def test_what_a_record_does_not_carry_is_refused_and_only_a_detector_is_written_over(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    before = (tmp_path / "run.csv").read_bytes()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty.json").touch()
    (tmp_path / "link").symlink_to("pipe")
    for out in ("pipe", "link", ".", "empty.json", "absent/x.json", "run.csv"):
        refused(hydrofdi, "run.csv", *TRAIN[:-1], out, "--window", "1 s")
    for more in (["--window", "50 s"], ["--healthy", "sound"], ["--false-alarm-rate", "1e-300"]):
        refused(hydrofdi, "run.csv", *TRAIN, *more)
    assert (tmp_path / "pipe").is_fifo()
    assert not (tmp_path / "absent").exists()
    assert (tmp_path / "empty.json").read_bytes() == b""
    assert (tmp_path / "run.csv").read_bytes() == before
    (tmp_path / "detector.json").symlink_to("target.json")
    for _ in range(2):
        told(hydrofdi, "run.csv", *TRAIN, "--window", "1 s", "--every", "0.5 s")
    assert (tmp_path / "detector.json").is_symlink()
    assert load_detector(tmp_path / "target.json").limits.interval_rests_on == "windows"
