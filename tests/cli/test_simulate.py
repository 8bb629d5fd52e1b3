import json

import h5py
import pytest

import hydrofdi as package
from hydrofdi.api.run import simulate
from hydrofdi.config import load_experiment

SHORT = ("--set", "record.duration=2 s")


def test_without_arguments_the_nominal_actuator_runs_from_any_folder_and_writes_nothing(hydrofdi, tmp_path):
    result = hydrofdi("simulate")
    assert result.returncode == 0
    assert result.stderr == ""
    for word in ("L/min", "d1", "d5", "kPa", "MPa", "f_h", "ζ"):
        assert word in result.stdout
    assert not list(tmp_path.iterdir())


def test_what_is_stored_is_what_is_printed(hydrofdi, tmp_path):
    result = hydrofdi("simulate", *SHORT, "--out", "folder/run.h5", "--figure", "folder/run.png", "--json")
    printed = json.loads(result.stdout)
    with h5py.File(tmp_path / "folder" / "run.h5") as file:
        assert file["run_id"].asstr()[0] == printed["run_id"]
        assert file["detail_rms"][0].tolist() == printed["detail_rms_Pa"]
        assert file["chamber_1_pressure"].shape == (1, 1000)
    assert (tmp_path / "folder" / "run.png").read_bytes().startswith(b"\x89PNG")
    report = hydrofdi("report", "folder/run.h5", "--json")
    assert json.loads(report.stdout)["rows"][0]["detail_rms_Pa"] == printed["detail_rms_Pa"]


def test_a_run_that_diverges_is_stored_with_a_sentence_and_exit_code_1(hydrofdi, tmp_path):
    result = hydrofdi("simulate", *SHORT, "--set", "fluid.bulk_modulus=1e13", "--json", "--out", "run.h5")
    assert result.returncode == 1
    printed = json.loads(result.stdout)
    assert printed["status"] == "diverged"
    assert printed["detail_rms_Pa"] == [None] * 5
    assert "the state grew without bound" in result.stderr
    assert "warning: the step of 0.0001 s is too long for the hydraulic mode" in result.stderr
    with h5py.File(tmp_path / "run.h5") as file:
        assert file["status"].asstr()[0] == "diverged"


@pytest.mark.parametrize(
    "settings",
    [
        ["input.amplitude=0"],
        ["input.amplitude=0", "leakage.internal_coefficient=1e-8"],
        ["wavelet.levels=1"],
        ["wavelet.name=haar", "wavelet.extension=periodization"],
        ["supply.return_pressure=17 MPa"],
        ["leakage.external_coefficient=1e-6"],
        ["actuator.piston_area=1e200"],
        ["actuator.mass=1e-300"],
        ["valve.natural_frequency=1e200"],
        ["friction.velocity_threshold=1e-300"],
    ],
)
def test_odd_but_valid_parameters_end_in_a_run_or_in_a_failed_one(settings):
    single = simulate(load_experiment(None, ["record.duration=2 s", *settings]))
    record = single.to_dict()
    assert record["status"] in ("ok", "diverged", "stroke_exceeded")
    json.dumps(record, allow_nan=False)


def test_the_version_is_printed(hydrofdi):
    result = hydrofdi("--version")
    assert (result.returncode, result.stdout) == (0, f"hydrofdi {package.__version__}\n")


def test_the_edges_of_bands_matter_to_wavelets_alone():
    run = package.check({"name": "balance", "indicators": {"flow_balance": {}}}, duration="2 s")
    assert not any("wavelet level" in warning for warning in run.warnings)
    followed = {"name": "followed", "indicators": {"sliding": {"of": "dwt"}}}
    assert any("wavelet level" in warning for warning in package.check(followed, duration="4 s").warnings)
