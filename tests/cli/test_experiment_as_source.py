"""An experiment file as a source of records, and a single run as a file."""

import pytest

from tests.commands import run, run_json

MANY = """
name: many
record: {duration: 2 s}
sweep: {grid: {supply.pressure: {linspace: [15 MPa, 17 MPa, 40]}}}
"""
STUDY = """
name: press
record: {duration: 2 s}
study:
  population: {over: {friction.scale: {uniform: ±30 %}}}
  healthy: {fit: 4, test: 4}
  faults: {leakage.internal_flow: [0.5 L/min], each: 2, fit: 0}
"""


@pytest.fixture
def many(tmp_path):
    file = tmp_path / "many.yaml"
    file.write_text(MANY)
    return file


def test_whoever_simulates_an_experiment_file_says_at_once_how_many_records(many, tmp_path):
    measured = run("measure", many, "--format", "csv", check=0)
    assert measured.stderr.splitlines()[0] == f"{many}: simulating 40 records"
    assert len(measured.stdout.splitlines()) == 41
    for command in (
        ("export", many, "--out", tmp_path / "signals"),
        ("replay", many, "--rate", "max", "--record", "1"),
    ):
        assert f"{many}: simulating 40 records" in run(*command, check=0).stderr


def test_a_first_look_finds_the_record_that_is_named(many):
    names = [record["record_id"] for record in run_json("measure", many)["records"]]
    assert len(names) == 40
    found = [run_json("inspect", many, "--record", name)["records"] for name in names[:6]]
    assert {*found} == {32, 33}


def test_the_single_run_of_a_study_keeps_its_signals(tmp_path):
    study, stored = tmp_path / "press.yaml", tmp_path / "run.h5"
    study.write_text(STUDY)
    run("simulate", study, "--out", stored)
    run("export", stored, "--out", tmp_path / "run.csv", check=0)
    assert (tmp_path / "run.csv").read_text().startswith("time [s],P1 [Pa],P2 [Pa]")


def test_a_single_run_without_signals_is_to_be_simulated_again(tmp_path):
    stored = tmp_path / "run.h5"
    run("simulate", "--set", "store.signals=none", "--set", "record.duration=2 s", "--out", stored)
    refused = run("export", stored, "--out", tmp_path / "run.csv", check=2)
    assert refused.stderr == (
        f"hydrofdi: {stored}: contains no signals; set store: {{signals: all}} and simulate again\n"
    )
