"""``hydrofdi train``: healthy records alone teach, the summary says what the promise rests on."""

import json
import os

import numpy as np
import pytest

from hydrofdi.detectors.trained.reading import load_detector
from tests.conftest import sweep_in

HEADER = "time [s],P1 [bar],P2 [bar],u [V]"


def write_record(path, seed, leak=0.0, n_sample=400):
    """A measured file: pressures of a motion with noise, their swing smaller where it leaks."""
    draw = np.random.default_rng(seed)
    time = np.arange(n_sample) / 100.0
    swing = (1.0 - leak) * np.sin(2.0 * np.pi * time)
    rows = np.column_stack(
        [
            time,
            80.0 + 20.0 * swing + 0.2 * draw.standard_normal(n_sample),
            80.0 - 20.0 * swing + 0.2 * draw.standard_normal(n_sample),
            np.sign(swing),
        ]
    )
    path.parent.mkdir(exist_ok=True)
    np.savetxt(path, rows, fmt="%.6g", delimiter=",", header=HEADER, comments="")


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
    refused = hydrofdi("train", "measured.yaml", *TRAIN)
    assert refused.returncode == 2
    assert "measured.yaml: which records are healthy?" in refused.stderr
    refused = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "soud")
    assert "no record has the label 'soud'; found 'sound', 'worn'; did you mean 'sound'?" in refused.stderr
    done = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "sound", "--window", "1 s")
    assert done.returncode == 0, done.stderr
    file = load_detector(measured / "detector.json")
    assert file.basis.populations == {"sound": 120}
    assert (file.basis.n_record, file.basis.n_group) == (30, 3)
    assert file.limits.interval_rests_on == "groups"
    assert file.limits.high is None
    assert file.channels == ("chamber_1_pressure",)
    told = " ".join(done.stdout.split())
    assert (
        "It rests on 120 windows that do not overlap, from 30 healthy records in 3 groups: sound (120)."
        in told
    )
    assert "Left out because they are not healthy training records: 12." in told
    assert "leave-one-group-out" in told
    assert "That is 360 false alarms an hour" in told


def test_records_that_repeat_the_samples_of_another_teach_once(hydrofdi, measured):
    (measured / "runs/day 1 sound 10.csv").write_bytes((measured / "runs/day 1 sound 9.csv").read_bytes())
    (measured / "runs/day 1 sound 11.csv").write_text(HEADER + "\n")
    done = hydrofdi("train", "measured.yaml", *TRAIN, "--healthy", "sound", "--json")
    assert done.returncode == 1
    told = json.loads(done.stdout)
    assert told["detector"]["basis"]["n_record"] == 30
    assert (told["left_out"]["n_repeated"], told["left_out"]["n_rejected"]) == (1, 1)
    assert "day 1 sound 9.csv" in done.stderr


def test_a_source_that_is_named_twice_teaches_once(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    done = hydrofdi("train", "run.csv", "run.csv", *TRAIN, "--window", "1 s", "--json")
    assert done.returncode == 1
    assert json.loads(done.stdout)["detector"]["basis"]["n_record"] == 1
    assert "left out as repeats: 1 record; run.csv repeats run.csv" in done.stderr


def test_two_short_records_say_that_nothing_is_known_of_others(hydrofdi, tmp_path):
    for seed in (1, 2):
        write_record(tmp_path / f"{seed}.csv", seed, n_sample=700)
    done = hydrofdi("train", "1.csv", "2.csv", *TRAIN, "--window", "1 s")
    assert done.returncode == 0, done.stderr
    told = " ".join(done.stdout.split())
    assert "windows taken as independent" in told
    assert "so the interval does not include how records differ." in told


def test_healthy_windows_that_are_all_at_fault_are_not_called_too_short(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1)
    lines = (tmp_path / "run.csv").read_text().splitlines()
    still = [lines[0], *(f"{line.partition(',')[0]},80,{line.split(',', 2)[2]}" for line in lines[1:])]
    (tmp_path / "run.csv").write_text("\n".join(still) + "\n")
    refused = hydrofdi("train", "run.csv", *TRAIN, "--window", "1 s")
    assert refused.returncode == 2
    assert "chamber_1_pressure" in refused.stderr


def test_one_record_says_what_its_promise_rests_on(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    done = hydrofdi("train", "run.csv", *TRAIN, "--window", "1 s", "--every", "0.5 s")
    assert done.returncode == 0, done.stderr
    told = " ".join(done.stdout.split())
    assert "It judges windows of 1 s, one every 0.5 s, at 100 Hz and needs P1 (chamber_1_pressure)." in told
    assert "One record: nothing is known of other days or machines." in told
    assert "windows taken as independent" in told
    assert "No record has a label: all are assumed to be healthy." in told
    assert load_detector(tmp_path / "detector.json").limits.interval_rests_on == "windows"
    refused = hydrofdi("train", "run.csv", *DETECTOR, "--window", "1 s", "--out", "detector.json")
    assert "needs 99 healthy windows that do not overlap (1.65 min), and there are 40;" in refused.stderr
    assert "take more records, shorter windows or a higher false_alarm_rate" in refused.stderr
    refused = hydrofdi("train", "run.csv", *TRAIN, "--window", "50 s")
    assert "the longest one lasts 40 s, but a window 50 s; give a shorter window" in refused.stderr
    refused = hydrofdi("train", "run.csv", *TRAIN, "--healthy", "sound")
    assert "healthy: no record has the label 'sound'; found none" in refused.stderr


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
    assert (file.config.window.duration, file.config.direction, file.limits.false_alarm_rate) == (
        1.0,
        "both",
        0.2,
    )
    assert file.config.chart.options == {"direction": "both", "weight": 0.1, "variance": "exact"}
    assert "The chart ewma has the limit" in done.stdout
    wrong = "extends: base.yaml\nindicatr: dwt\nchart: {chart: cusm}\n"
    (tmp_path / "wrong.yaml").write_text(wrong)
    refused = hydrofdi(
        "train", "run.csv", "--config", "wrong.yaml", "--every", "1 bar", "--out", "detector.json"
    )
    assert refused.returncode == 2
    lines = refused.stderr.splitlines()
    assert "hydrofdi: wrong.yaml:2: indicatr: unknown key; did you mean 'indicator'?" in lines
    assert any(line.startswith("hydrofdi: every: '1 bar' has the wrong unit") for line in lines)
    (tmp_path / "wrong.yaml").write_text("indicator: dwt\noutput: d9\nchart: {chart: cusm}\n")
    lines = hydrofdi("train", "run.csv", "--config", "wrong.yaml", "--out", "x.json").stderr.splitlines()
    assert "hydrofdi: wrong.yaml:3: chart.chart: there is no chart 'cusm'; did you mean 'cusum'?" in lines
    assert any(line.startswith("hydrofdi: wrong.yaml:2: output: dwt has no output 'd9'") for line in lines)


def test_estimates_of_a_recursive_indicator_set_limits_record_by_record(hydrofdi, tmp_path):
    (tmp_path / "study.yaml").write_text(
        """\
name: study
record: {duration: 4 s}
input: {shape: square, period: 1 s}
study:
  population: {over: {fluid.bulk_modulus: {normal: ±5 %}}}
  healthy: {fit: 8, test: 1}
"""
    )
    (tmp_path / "mine.yaml").write_text("indicator: weak_rls\nwindow: {by: estimate}\n")
    done = hydrofdi("train", "study.yaml", "--config", "mine.yaml", *TRAIN[-4:])
    assert done.returncode == 0, done.stderr
    file = load_detector(tmp_path / "detector.json")
    assert (file.n_sample, file.basis.n_window) == (0, 8 * 20)
    assert file.limits.interval_rests_on == "records"
    assert "Estimates follow each other closely" in done.stdout
    refused = hydrofdi("train", "study.yaml", "--by", "estimate", "--direction", "both", *TRAIN[-4:])
    assert "dwt is not recursive" in refused.stderr
    refused = hydrofdi("train", "study.yaml", "--config", "mine.yaml", "--window", "1 s", *TRAIN[-4:])
    assert "by=estimate: this setting has no windows" in refused.stderr


def test_nothing_but_a_detector_is_overwritten(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    before = (tmp_path / "run.csv").read_bytes()
    refused = hydrofdi("train", "run.csv", *TRAIN[:-1], "run.csv", "--window", "1 s")
    assert refused.returncode == 2
    assert "run.csv: already exists, is not a detector file and was not changed" in refused.stderr
    assert (tmp_path / "run.csv").read_bytes() == before
    for _ in range(2):
        assert hydrofdi("train", "run.csv", *TRAIN, "--window", "1 s").returncode == 0


def test_only_a_detector_or_nothing_stands_where_a_detector_is_written(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty.json").touch()
    (tmp_path / "link").symlink_to("pipe")
    for out, said in (
        ("pipe", "pipe: is not a regular file and was not changed"),
        ("link", "link: is not a regular file and was not changed"),
        (".", "is not a regular file and was not changed"),
        ("empty.json", "empty.json: already exists, is not a detector file and was not changed"),
        ("absent/x.json", "absent/x.json: there is no folder "),
    ):
        refused = hydrofdi("train", "run.csv", *TRAIN[:-1], out, "--window", "1 s")
        assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)
        assert said in refused.stderr
    assert (tmp_path / "pipe").is_fifo()
    assert not (tmp_path / "absent").exists()
    assert (tmp_path / "empty.json").read_bytes() == b""


def test_behind_a_symbolic_link_the_detector_is_written_and_the_link_stays(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1, n_sample=4000)
    (tmp_path / "detector.json").symlink_to("target.json")
    for _ in range(2):
        assert hydrofdi("train", "run.csv", *TRAIN, "--window", "1 s").returncode == 0
    assert (tmp_path / "detector.json").is_symlink()
    load_detector(tmp_path / "target.json")


def test_a_rate_that_nobody_can_show_is_refused_in_a_short_sentence(hydrofdi, tmp_path):
    write_record(tmp_path / "run.csv", 1)
    refused = hydrofdi("train", "run.csv", *TRAIN, "--false-alarm-rate", "1e-300")
    assert refused.returncode == 2
    assert "false_alarm_rate: must be at least 1e-09; found 1e-300" in refused.stderr
