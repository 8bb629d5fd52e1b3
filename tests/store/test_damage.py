"""Files of earlier versions, as written, and damaged."""

import contextlib
import json
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.stored import read_results
from hydrofdi.errors import StoreError
from hydrofdi.report.composition import Report
from hydrofdi.report.runs import run_table
from hydrofdi.store.folder.lock import experiment_lock
from hydrofdi.store.index import read_index
from hydrofdi.store.layout import names
from hydrofdi.store.reading import read_experiment
from tests.conftest import run_hydrofdi, sweep_in

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


MUSEUM = Path(__file__).parent.parent / "museum"
READABLE = ("format_4_physics_3",)


def reported(place, *arguments):
    result = run_hydrofdi("report", place, *arguments, cwd=MUSEUM)
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout


def then(version, name):
    return json.loads((MUSEUM / version / "reported.json").read_text(encoding="utf-8"))[name]


def assert_same_rows(rows, earlier):
    """Rows as they were reported, in any order; what an earlier version did not report is left out."""
    assert len(rows) == len(earlier)
    for row, before in zip(sorted(rows, key=_details), sorted(earlier, key=_details), strict=True):
        output = {name: value for name, value in before.items() if value is not None}
        assert {name: row[name] for name in output} == output


def _details(row):
    return row["detail_rms_Pa"]


@pytest.mark.parametrize("version", READABLE)
@pytest.mark.parametrize("name", ["kept", "pressures"])
def test_a_file_is_reported_with_the_numbers_and_labels_that_it_had(version, name):
    rows = json.loads(
        reported(MUSEUM / version / ("kept/kept.h5" if name == "kept" else "pressures.h5"), "--json")
    )
    assert_same_rows(rows["rows"], then(version, name))


@pytest.mark.parametrize("version", READABLE)
def test_a_folder_is_reported_from_its_file(version):
    folder = MUSEUM / version / "kept"
    assert_same_rows(json.loads(reported(folder, "--json"))["rows"], then(version, "kept"))
    assert "not computed yet" not in reported(folder)


def test_shards_without_a_file_are_found_by_the_identities_of_their_own_physics(tmp_path):
    folder = tmp_path / "kept"
    shutil.copytree(MUSEUM / "format_4_physics_3" / "kept", folder)
    (folder / "kept.h5").unlink()
    rows = json.loads(reported(folder, "--json"))["rows"]
    assert_same_rows(rows, then("format_4_physics_3", "kept"))


@pytest.mark.parametrize("version", READABLE)
def test_xarray_opens_every_file(version):
    for path in (MUSEUM / version).rglob("*.h5"):
        if path.parent.name == "shards":
            continue
        with xarray.open_dataset(path, engine="h5netcdf") as runs:
            assert runs.detail_rms.attrs["units"] == "Pa"
            assert np.isfinite(runs.detail_rms).all()


def test_a_format_that_is_no_longer_read_is_refused_plainly():
    result = run_hydrofdi("report", MUSEUM / "format_1" / "kept.h5", cwd=MUSEUM)
    assert result.returncode == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert "format version 1, which this hydrofdi no longer reads" in line


def test_no_piece_names_the_machine_that_wrote_it():
    for path in MUSEUM.rglob("*"):
        assert path.name not in ("provenance.json", "run.log", ".lock")
        if path.is_file():
            assert not [mark for mark in (b"/home/", b"/root/", b"/tmp/") if mark in path.read_bytes()]


FRICTION = """\
name: friction
record: {duration: 1 s}
store: {signals: none}
leakage: {external_coefficient: 1e-13}
baseline: {friction.viscous: 70 N·s/m, leakage.external_coefficient_1: 0}
sweep:
  grid:
    friction.viscous: [50 N·s/m, 250 N·s/m]
    leakage.internal_coefficient: [0, 1e-8]
"""


@pytest.fixture(scope="module")
def friction(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("friction"), FRICTION)


def changed_file(sweep, folder, change):
    """A copy of an experiment file whose configuration is another."""
    path = folder / "changed.h5"
    shutil.copy(sweep.file, path)
    with h5py.File(path, "a") as file:
        configuration = json.loads(file.attrs["configuration"])
        change(configuration)
        file.attrs["configuration"] = json.dumps(configuration)
    return path


def test_a_row_keeps_its_labels_where_the_sweep_would_be_expanded_in_another_order(friction, tmp_path):
    path = changed_file(
        friction, tmp_path, lambda c: c["sweep"]["grid"].update({"friction.viscous": [250.0, 50.0]})
    )
    before, after = (
        dict(
            zip(
                table.texts("run_id"),
                zip(table.labels, table["detail_rms"].tolist(), strict=True),
                strict=True,
            )
        )
        for table in map(run_table, map(read_results, (friction.file, path)))
    )
    assert after == before
    assert {labels["friction.viscous"] for labels, *_ in after.values()} == {50.0, 70.0, 250.0}


def test_parameters_that_only_the_baseline_changes_are_known_of_every_row(friction):
    data = read_results(friction.file)
    healthy = set(data.matched_baseline.tolist()) | set(data.fixed_baseline.tolist())
    inside = data.values("leakage.external_coefficient_1")
    assert {row for row, value in enumerate(inside) if value == 0.0} == healthy
    assert {value for row, value in enumerate(inside) if row not in healthy} == {None}
    (fixed,) = set(data.fixed_baseline.tolist())
    assert data.values("friction.viscous")[fixed] == 70.0


@pytest.fixture(scope="module")
def leaky_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("single")
    settings = ("--set=leakage.internal_coefficient=1e-8", "--set=record.duration=1 s")
    assert run_hydrofdi("simulate", *settings, "--out", "run.h5", cwd=folder).returncode == 0
    return folder / "run.h5"


def test_a_leaky_run_by_itself_has_no_baseline_and_no_delta(leaky_run):
    result = run_hydrofdi("report", leaky_run, "--json", cwd=leaky_run.parent)
    record = json.loads(result.stdout)
    (row,) = record["rows"]
    assert row["delta_fixed_percent"] == row["delta_matched_percent"] == [None] * 5
    assert row["detail_rms_Pa"][1] > 0.0
    assert record["delta_not_known"].startswith("There is no healthy run to compare with")


def test_a_baseline_that_leaks_is_none_in_files_that_name_one(leaky_run, tmp_path):
    """Files of earlier versions made a leaky run its own baseline."""
    path = tmp_path / "earlier.h5"
    shutil.copy(leaky_run, path)
    with h5py.File(path, "a") as file:
        assert file[names.FIXED_BASELINE][0] == names.NO_BASELINE
        file[names.FIXED_BASELINE][0] = file[names.MATCHED_BASELINE][0] = 0
    assert not Report(read_results(path)).has_baseline


def test_a_healthy_run_by_itself_is_its_own_baseline(tmp_path):
    settings = ("--set=record.duration=1 s", "--out", "run.h5")
    assert run_hydrofdi("simulate", *settings, cwd=tmp_path).returncode == 0
    assert read_results(tmp_path / "run.h5").fixed_baseline.tolist() == [0]
