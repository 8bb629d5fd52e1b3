import json
import os

import h5py
import pytest

import hydrofdi as package
from hydrofdi.config import load_experiment
from tests.conftest import SMALL

IN_PROCESS = ("--engine", "in-process")

NO_NETWORK = """
import socket

class Blocked(socket.socket):
    def connect(self, address):
        if self.family in (socket.AF_INET, socket.AF_INET6):
            raise RuntimeError(f"connection to {address}")
        return super().connect(address)

socket.socket = Blocked
"""


def test_options_are_a_sweep_and_the_file_that_they_write_is_the_same(hydrofdi, tmp_path):
    short = ("--set", "duration=2 s", "--set", "store.signals=none", *IN_PROCESS)
    axes = ("--grid", "EBM=551MPa:827MPa:3", "--grid", "K_i=0,1e-8", "--name", "mine")
    assert hydrofdi("sweep", *axes, *short, "--write", "mine.yaml").returncode == 0
    with h5py.File(tmp_path / "results/mine/mine.h5") as file:
        assert len(set(zip(file["EBM"][:], file["K_i"][:], strict=True))) == 6
    again = hydrofdi("sweep", "mine.yaml", *IN_PROCESS, "--json")
    assert json.loads(again.stdout)["skipped"] == 6
    paired = hydrofdi("plan", "--zip", "EBM=8e8,9e8", "--zip", "K_i=[0, 1e-8]", "--json")
    assert json.loads(paired.stdout)["swept"] == 2
    assert hydrofdi("sweep", *axes, *short, "--write", "mine.yaml").returncode == 2


@pytest.mark.parametrize("axes", [
    "--grid EBM=6e8,7e8 --grid fluid.bulk_modulus=8e8", "--grid K_i=0,1e-8 --grid q_il=0,1e-5",
    "--zip K_i=0,1e-8 --zip q_il=0,1e-5", "--set bulk_modulus=6e8 --set EBM=7e8", "--grid EBM", "",
])  # fmt: skip
def test_an_axis_is_never_dropped_silently(hydrofdi, axes):
    refused = hydrofdi("plan", *axes.split())
    assert (refused.returncode, len(refused.stderr.splitlines())) == (2, 1)


def test_no_connection_is_made(hydrofdi, tmp_path, experiment_file):
    guard = tmp_path / "guard"
    guard.mkdir()
    (guard / "sitecustomize.py").write_text(NO_NETWORK)
    environment = {**os.environ, "PYTHONPATH": str(guard)}
    assert hydrofdi("sweep", experiment_file(SMALL), "--workers", "2", env=environment).returncode == 0
    assert hydrofdi("report", env=environment).returncode == 0


def test_records_and_features_of_different_lengths_fit_into_a_file_without_signals(hydrofdi, experiment_file):
    config = experiment_file("sweep: {grid: {record.duration: [2 s, 4 s]}}\n")
    result = hydrofdi("sweep", config, *IN_PROCESS)
    assert result.returncode == 2
    assert "store: {signals: none}" in result.stderr
    assert hydrofdi("sweep", config, *IN_PROCESS, "--set", "store.signals=none").returncode == 0
    for axis in ("levels=[4, 5]", "phase=[0, 3, all]"):
        settings = ("--set", "record.duration=4 s", "--set", "store.signals=none")
        assert hydrofdi("plan", *settings, "--grid", f"wavelet.{axis}").returncode == 0


SHUT = """\
name: shut
record: {duration: 2 s}
store: {signals: none}
sweep: {grid: {leakage.internal_flow: [0, 2 L/min], %s}}
"""


def test_commands_without_any_possible_leak_name_each_condition_and_store_nothing(
    hydrofdi, experiment_file, tmp_path
):
    config = experiment_file(SHUT % "friction.viscous: [50 N*s/m, 60 N*s/m]")
    still = ("--set", "record.duration=2 s", "--set", "input.amplitude=0 V")
    result = hydrofdi("sweep", config, *IN_PROCESS, *still)
    told = "hydrofdi: leakage.internal_flow"
    lines = [line for line in result.stderr.splitlines() if line.startswith(told)]
    assert all(f"friction.viscous = {n} " in line for n, line in zip((50, 60), lines, strict=True))
    assert (result.returncode, os.listdir(tmp_path)) == (2, [config.name])
    leak = ("--set", "leakage.internal_flow=2 L/min")
    for command in (("simulate", *leak), ("calibrate", "--flow", "2 L/min")):
        result = hydrofdi(*command, *still)
        assert (result.returncode, result.stderr.startswith(f"{told}: ")) == (2, True)
    result = hydrofdi("check", *leak, *still, "--json")
    assert any(each.startswith("leakage.internal_flow: ") for each in json.loads(result.stdout)["problems"])
    assert result.returncode == 1


def test_without_arguments_the_nominal_actuator_runs_from_any_folder_and_writes_nothing(hydrofdi, tmp_path):
    result = hydrofdi("simulate")
    assert (result.returncode, result.stderr) == (0, "")
    assert not list(tmp_path.iterdir())
    assert hydrofdi("--version").stdout == f"hydrofdi {package.__version__}\n"


@pytest.mark.parametrize("is_wild", [False, True])
def test_what_is_stored_is_what_is_printed_also_of_a_run_that_diverges(hydrofdi, tmp_path, is_wild):
    settings = ["record.duration=2 s", *(["fluid.bulk_modulus=1e13"] if is_wild else [])]
    options = [part for each in settings for part in ("--set", each)]
    result = hydrofdi("simulate", *options, "--out", "folder/run.h5", "--figure", "folder/run.png", "--json")
    printed = json.loads(result.stdout)
    assert (result.returncode, printed["status"]) == ((1, "diverged") if is_wild else (0, "ok"))
    with h5py.File(tmp_path / "folder" / "run.h5") as file:
        assert file["run_id"].asstr()[0] == printed["run_id"]
        assert file["status"].asstr()[0] == printed["status"]
        assert file["chamber_1_pressure"].shape == (1, 1000)
    (row,) = json.loads(hydrofdi("report", "folder/run.h5", "--json").stdout)["rows"]
    assert row["detail_rms_Pa"] == printed["detail_rms_Pa"]
    assert (printed["detail_rms_Pa"] == [None] * 5) == is_wild
    assert ("the state grew without bound" in result.stderr) == is_wild
    assert (" is too long for the hydraulic mode" in result.stderr) == is_wild
    if not is_wild:
        assert (tmp_path / "folder" / "run.png").read_bytes().startswith(b"\x89PNG")


def test_odd_but_valid_parameters_end_in_a_run_or_in_a_failed_one():
    for settings in (
        ["input.amplitude=0", "leakage.internal_coefficient=1e-8"],
        ["wavelet.name=haar", "wavelet.extension=periodization", "wavelet.levels=1"],
        ["supply.return_pressure=17 MPa"],
        ["leakage.external_coefficient=1e-6"],
        ["actuator.piston_area=1e200"],
        ["actuator.mass=1e-300"],
        ["valve.natural_frequency=1e200"],
        ["friction.velocity_threshold=1e-300"],
    ):
        record = package.simulate(load_experiment(None, ["record.duration=2 s", *settings])).to_dict()
        assert record["status"] in ("ok", "diverged", "stroke_exceeded"), settings
        json.dumps(record, allow_nan=False)


def test_the_edges_of_bands_matter_to_wavelets_alone():
    for indicators, is_told in (({"flow_balance": {}}, False), ({"sliding": {"of": "dwt"}}, True)):
        checked = package.check({"name": "followed", "indicators": indicators}, duration="4 s")
        assert any("wavelet levels" in warning for warning in checked.warnings) == is_told
