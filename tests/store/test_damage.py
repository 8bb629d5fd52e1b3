"""Files that are broken, and writers that are killed."""

import contextlib
import json
import random
import shutil
import signal
import subprocess
import sys
import time

import h5py
import pytest

from hydrofdi.errors import StoreError
from hydrofdi.store.folder.lock import experiment_lock
from hydrofdi.store.index import read_index
from hydrofdi.store.reading import read_experiment

WRITER = """
import sys
from pathlib import Path
import numpy as np
from hydrofdi.config.experiment import StoreConfig
from hydrofdi.store.shard import write_shard
from hydrofdi.store.layout import names

n_run, n_time = 16, 40_000
columns = {names.TIME: np.arange(float(n_time))}
for variable in names.stored_variables("all"):
    shape = {names.TIME: n_time, names.LEVEL: 5}.get(variable.dimensions[-1])
    columns[variable.name] = np.ones((n_run, shape) if shape else n_run)
columns[names.STATUS] = columns[names.MESSAGE] = ["ok"] * n_run
for number in range(10_000):
    run_ids = [f"{number:08d}{row:08d}" for row in range(n_run)]
    columns[names.RUN_ID] = run_ids
    write_shard(Path(sys.argv[1]), columns, StoreConfig())
    print(number, flush=True)
"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_writer_killed_in_mid_write_leaves_whole_shards_or_none(tmp_path, seed):
    process = subprocess.Popen([sys.executable, "-c", WRITER, tmp_path], stdout=subprocess.PIPE, text=True)
    acknowledged = [int(process.stdout.readline()) for _ in range(2)][-1]
    time.sleep(random.Random(seed).uniform(0.0, 0.1))
    process.send_signal(signal.SIGKILL)
    acknowledged = max([acknowledged, *map(int, process.stdout.read().split())])
    process.stdout.close()
    process.wait()
    index = read_index(tmp_path)
    assert not index.damaged
    assert len(index.runs) >= 16 * (acknowledged + 1)
    for path in {run.shard for run in index.runs.values()}:
        with h5py.File(path) as file:
            assert all(dataset[()].size for dataset in file.values())


def test_a_file_cut_short_anywhere_is_reported_as_damaged(small_sweep, tmp_path):
    whole = small_sweep.file.read_bytes()
    path = tmp_path / "cut.h5"
    for length in (0, 1, 100, 2000, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(StoreError, match=r"cut\.h5: "):
            read_experiment(path)


def test_flipped_bytes_are_read_or_reported_as_damage(small_sweep, tmp_path):
    whole = small_sweep.file.read_bytes()
    path = tmp_path / "flipped.h5"
    chance = random.Random(3)
    for _ in range(150):
        broken = bytearray(whole)
        for _ in range(20):
            broken[chance.randrange(12_000)] ^= 1 << chance.randrange(8)
        path.write_bytes(broken)
        with contextlib.suppress(StoreError):
            assert read_experiment(path).n_run == 4


def test_the_report_of_a_damaged_file_is_one_line_and_exit_code_2(hydrofdi, small_sweep, tmp_path):
    path = tmp_path / "results" / "broken" / "broken.h5"
    path.parent.mkdir(parents=True)
    path.write_bytes(small_sweep.file.read_bytes()[:5000])
    for arguments in ([], [path.parent], [path]):
        result = hydrofdi("report", *arguments)
        assert (result.returncode, result.stdout) == (2, "")
        (line,) = result.stderr.splitlines()
        assert "broken.h5: " in line


def test_a_damaged_result_is_made_again_by_the_next_sweep(hydrofdi, small_sweep, tmp_path):
    shutil.copytree(small_sweep.folder, tmp_path, dirs_exist_ok=True)
    directory = tmp_path / "results" / "small"
    shard = next((directory / "shards").glob("*.h5"))
    shard.write_bytes(shard.read_bytes()[:3000])
    (directory / "small.h5").write_bytes(b"")
    result = hydrofdi("sweep", "experiment.yaml", "--json", "--engine", "in-process")
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["completed"] == 4
    with h5py.File(directory / "small.h5") as file, h5py.File(small_sweep.file) as whole:
        assert (file["detail_rms"][:] == whole["detail_rms"][:]).all()


def test_status_names_a_damaged_shard_and_ends_with_exit_code_1(hydrofdi, small_sweep, tmp_path):
    shutil.copytree(small_sweep.folder, tmp_path, dirs_exist_ok=True)
    directory = tmp_path / "results" / "small"
    sound = hydrofdi("status", directory)
    assert (sound.returncode, sound.stdout) == (0, "4 planned, 4 done, 0 failed, 0 missing (4 ok)\n")
    shard = next((directory / "shards").glob("*.h5"))
    shard.write_bytes(shard.read_bytes()[:3000])
    output = hydrofdi("status", directory)
    assert output.returncode == 1
    assert f"{shard.name}: is damaged" in output.stdout
    record = json.loads(hydrofdi("status", directory, "--json").stdout)
    assert record["missing"] == 4
    assert [shard.name in fault for fault in record["damaged"]] == [True]


def test_nothing_is_collected_beside_a_running_sweep(hydrofdi, small_sweep, tmp_path):
    shutil.copytree(small_sweep.folder, tmp_path, dirs_exist_ok=True)
    directory = tmp_path / "results" / "small"
    (directory / "small.h5").unlink()
    with experiment_lock(directory, print):
        refused = hydrofdi("collect", directory)
        assert refused.returncode == 2
        assert "another sweep is at work" in refused.stderr
        assert not (directory / "small.h5").exists()
    assert hydrofdi("collect", directory).returncode == 0
    assert (directory / "small.h5").exists()


@pytest.mark.parametrize(
    "change",
    [
        lambda file: file.attrs.__setitem__("format_version", 99),
        lambda file: file.attrs.__delitem__("configuration"),
        lambda file: file.attrs.__setitem__("configuration", "{"),
        lambda file: file.__delitem__("energy_residual"),
        lambda file: (file.__delitem__("status"), file.create_dataset("status", data=[3])),
        lambda file: (file.__delitem__("energy_residual"), file.create_group("energy_residual")),
        lambda file: file.__setitem__("more", h5py.ExternalLink("other.h5", "status")),
        lambda file: file.create_dataset("more", (1,), "f8", external=[("other", 0, 8)]),
    ],
)
def test_a_file_that_is_wrong_is_refused(small_sweep, tmp_path, change):
    path = tmp_path / "changed.h5"
    shutil.copy(small_sweep.file, path)
    with h5py.File(path, "a") as file:
        change(file)
    with pytest.raises(StoreError, match=r"changed\.h5"):
        read_experiment(path)
