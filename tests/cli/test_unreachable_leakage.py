"""Leakage flows that no K_i gives: a row with a reason beside runs that are possible, else a mistake."""

import os

import h5py

LAPS = """\
name: laps
record: {duration: 2 s}
store: {signals: none}
sweep: {grid: {leakage.internal_flow: [0, 2 L/min], valve.lap: %s}}
"""
SENTENCE = "hydrofdi: leakage.internal_flow: no K_i gives a mean leakage of 2 L/min"


def test_one_leak_out_of_reach_is_a_row_and_the_others_go_on(hydrofdi, experiment_file, tmp_path):
    result = hydrofdi("sweep", experiment_file(LAPS % "[0, 50 um]"), "--engine", "in-process")
    assert result.returncode == 1
    with h5py.File(tmp_path / "results/laps/laps.h5") as file:
        assert file["status"].asstr()[:].tolist() == ["ok", "ok", "ok", "unreachable_leakage"]
        assert file["message"].asstr()[3] == "no K_i gives a mean leakage of 2 L/min"
    more = experiment_file(LAPS % "[0, 50 um, 70 um]")
    assert hydrofdi("sweep", more, "--engine", "in-process").returncode == 1, "the possible leak is stored"
    report = hydrofdi("report", "results/laps")
    assert (report.returncode, "unreachable_leakage, 2 runs" in report.stdout) == (0, True)


def test_a_sweep_without_any_possible_leak_names_each_condition_and_stores_nothing(
    hydrofdi, experiment_file, tmp_path
):
    config = experiment_file(LAPS % "[60 um, 50 um]")
    result = hydrofdi("sweep", config, "--engine", "in-process")
    most = "; the most that this actuator leaks is 0 L/min"
    assert [line for line in result.stderr.splitlines() if line.startswith("hydrofdi: ")] == [
        f"{SENTENCE} at valve.lap = 60 µm{most}",
        f"{SENTENCE} at valve.lap = 50 µm{most}",
    ]
    assert (result.returncode, os.listdir(tmp_path)) == (2, [config.name])


def test_a_single_run_out_of_reach_keeps_its_one_line(hydrofdi):
    settings = ["--set", "record.duration=2 s", "--set", "valve.lap=50 um"]
    leak = ["--set", "leakage.internal_flow=2 L/min"]
    for command in (["simulate", *leak], ["check", *leak], ["calibrate", "--flow", "2 L/min"]):
        result = hydrofdi(*command, *settings)
        line = f"{SENTENCE}; the most that this actuator leaks is 0 L/min\n"
        assert (result.returncode, result.stderr) == (2, line)
