import json
import os
import shutil

import h5py
import numpy as np
import pytest

from tests.conftest import SMALL

NO_NETWORK = """
import socket

class Blocked(socket.socket):
    def connect(self, address):
        if self.family in (socket.AF_INET, socket.AF_INET6):
            raise RuntimeError(f"connection to {address}")
        return super().connect(address)

socket.socket = Blocked
"""


def test_results_go_where_out_says(hydrofdi, experiment_file, tmp_path):
    config = experiment_file("record: {duration: 2 s}\nstore: {signals: none}\n")
    result = hydrofdi("sweep", config, "--out", "else/where", "--engine", "in-process", "--json")
    assert json.loads(result.stdout)["file"] == "else/where/nominal.h5"
    assert (tmp_path / "else" / "where" / "nominal.h5").exists()
    assert not (tmp_path / "results").exists()


def test_a_run_that_diverges_is_a_stored_row_and_the_others_go_on(failing_sweep):
    assert failing_sweep.result.returncode == 1
    assert failing_sweep.summary["failed"] == 1
    with h5py.File(failing_sweep.file) as file:
        statuses, messages = file["status"].asstr()[:].tolist(), file["message"].asstr()[:].tolist()
        assert statuses == ["ok", "diverged", "ok"]
        assert [bool(message) for message in messages] == [False, True, False]
        assert "the state grew without bound" in messages[1]
        assert np.isfinite(file["detail_rms"][:]).all(axis=1).tolist() == [True, False, True]


def test_a_diverged_run_is_not_computed_again(hydrofdi, failing_sweep, tmp_path):
    shutil.copytree(failing_sweep.folder, tmp_path, dirs_exist_ok=True)
    result = hydrofdi("sweep", "experiment.yaml", "--json")
    assert result.returncode == 1
    assert json.loads(result.stdout)["completed"] == 0


def test_no_connection_is_made(hydrofdi, tmp_path, experiment_file):
    guard = tmp_path / "guard"
    guard.mkdir()
    (guard / "sitecustomize.py").write_text(NO_NETWORK)
    environment = {**os.environ, "PYTHONPATH": str(guard)}
    config = experiment_file(SMALL)
    assert hydrofdi("sweep", config, "--workers", "2", env=environment).returncode == 0
    assert hydrofdi("report", env=environment).returncode == 0


AXES = {
    "record.step": ["0.1 ms", "0.05 ms"], "wavelet.levels": [1, 3], "wavelet.name": ["db4", "haar"],
    "input.amplitude": ["1 V", "3 V"], "valve.natural_frequency": ["150 Hz", "160 Hz"],
    "supply.pressure": ["10 MPa", "11 MPa"],
}  # fmt: skip


def test_any_parameter_can_be_swept(hydrofdi, experiment_file):
    blocks = "".join(f"    - grid: {{{axis}: {json.dumps(values)}}}\n" for axis, values in AXES.items())
    config = experiment_file(f"record: {{duration: 2 s}}\nsweep:\n  union:\n{blocks}")
    result = hydrofdi("sweep", config, "--engine", "in-process")
    assert result.returncode == 0, result.stderr
    rows = json.loads(hydrofdi("report", "--json").stdout)["rows"]
    assert all(row["status"] == "ok" for row in rows)
    for axis in AXES:
        assert len({row["labels"][axis] for row in rows}) >= 2


def test_records_of_different_lengths_fit_into_a_file_without_signals(hydrofdi, experiment_file):
    config = experiment_file("sweep: {grid: {record.duration: [2 s, 4 s]}}\n")
    result = hydrofdi("sweep", config, "--engine", "in-process")
    assert result.returncode == 2
    assert "store: {signals: none}" in result.stderr
    assert hydrofdi("sweep", config, "--engine", "in-process", "--set", "store.signals=none").returncode == 0


@pytest.mark.parametrize("wavelet", ["wavelet.levels: [4, 5]", "wavelet.phase: [0, 3, all]"])
def test_a_plan_meets_features_of_different_shapes(hydrofdi, experiment_file, wavelet):
    text = f"record: {{duration: 4 s}}\nstore: {{signals: none}}\nsweep: {{grid: {{{wavelet}}}}}\n"
    assert hydrofdi("plan", experiment_file(text)).returncode == 0
