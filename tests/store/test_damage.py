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

from hydrofdi.errors import StoreError
from hydrofdi.report.composition import Report
from hydrofdi.report.runs import run_table
from hydrofdi.store import names
from hydrofdi.store.experiment_file import read_experiment
from hydrofdi.store.results import read_results
from hydrofdi.store.shards import read_index
from tests.commands import run, run_json
from tests.conftest import sweep_in

WRITER = """
import sys
from pathlib import Path
import numpy as np
from hydrofdi.config.experiment import StoreConfig
from hydrofdi.store.shards import write_shard
from hydrofdi.store import names

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


@pytest.mark.parametrize("seed", [1, 2])
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
    for path in {stored.shard for stored in index.runs.values()}:
        with h5py.File(path) as file:
            assert all(dataset[()].size for dataset in file.values())


def test_a_file_cut_short_or_with_flipped_bytes_is_read_or_reported_as_damaged(small_sweep, tmp_path):
    whole, path = small_sweep.file.read_bytes(), tmp_path / "damaged.h5"
    for length in (0, 1, 2000, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(StoreError, match=r"damaged\.h5: "):
            read_experiment(path)
    chance = random.Random(3)
    for _ in range(150):
        broken = bytearray(whole)
        for _ in range(20):
            broken[chance.randrange(12_000)] ^= 1 << chance.randrange(8)
        path.write_bytes(broken)
        with contextlib.suppress(StoreError):
            assert read_experiment(path).n_run == 4


@pytest.mark.parametrize(
    "change",
    [
        lambda file: file.attrs.__setitem__("format_version", 99),
        lambda file: file.attrs.__delitem__("configuration"),
        lambda file: file.attrs.__setitem__("configuration", "{"),
        lambda file: file.attrs.__setitem__("configuration", '{"name": "old", "replicates": {"count": 2}}'),
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
READABLE = MUSEUM / "format_4_physics_3"


@pytest.mark.parametrize("place", ["kept/kept.h5", "kept", "pressures.h5", "shards alone"])
def test_a_file_is_reported_with_the_numbers_and_labels_that_it_had_and_xarray_opens_it(place, tmp_path):
    """In any order; what an earlier version did not report is left out."""
    path = READABLE / place
    if place == "shards alone":  # found by the identities of their own physics
        shutil.copytree(READABLE / "kept", path := tmp_path / "kept")
        (path / "kept.h5").unlink()
    rows = run_json("report", path, cwd=MUSEUM)["rows"]
    reported = json.loads((READABLE / "reported.json").read_text(encoding="utf-8"))
    earlier = reported["pressures" if place == "pressures.h5" else "kept"]
    assert len(rows) == len(earlier)
    pairs = (sorted(each, key=lambda row: row["detail_rms_Pa"]) for each in (rows, earlier))
    for row, before in zip(*pairs, strict=True):
        output = {name: value for name, value in before.items() if value is not None}
        assert {name: row[name] for name in output} == output
    if path.suffix == ".h5":
        with xarray.open_dataset(path, engine="h5netcdf") as runs:
            assert runs.detail_rms.attrs["units"] == "Pa"
            assert np.isfinite(runs.detail_rms).all()


def test_a_format_that_is_no_longer_read_is_refused_plainly():
    refused = run("report", MUSEUM / "format_1" / "kept.h5", cwd=MUSEUM, check=2)
    assert refused.stdout == ""
    (line,) = refused.stderr.splitlines()
    assert "format version 1" in line


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


def test_rows_know_their_labels_in_whatever_order_the_sweep_is_expanded_and_those_of_the_baseline(tmp_path):
    friction = sweep_in(tmp_path, FRICTION)
    path = shutil.copy(friction.file, tmp_path / "changed.h5")
    with h5py.File(path, "a") as file:
        configuration = json.loads(file.attrs["configuration"])
        configuration["sweep"]["grid"]["friction.viscous"] = [250.0, 50.0]
        file.attrs["configuration"] = json.dumps(configuration)
    before, after = (
        dict(zip(table.texts("run_id"), zip(table.labels, table["dwt.d1"], strict=True), strict=True))
        for table in (run_table(read_results(each)) for each in (friction.file, path))
    )
    assert after == before
    assert {labels["friction.viscous"] for labels, _ in after.values()} == {50.0, 70.0, 250.0}
    data = read_results(friction.file)
    healthy = {*data.matched_baseline.tolist(), *data.fixed_baseline.tolist()}
    inside = data.values("leakage.external_coefficient_1")
    assert inside == [0.0 if row in healthy else None for row in range(len(inside))]
    (fixed,) = set(data.fixed_baseline.tolist())
    assert data.values("friction.viscous")[fixed] == 70.0


def test_a_run_by_itself_is_its_baseline_only_if_it_is_healthy(tmp_path):
    """Files of earlier versions made a leaky run its own baseline."""
    simulate = ("simulate", "--set=record.duration=1 s", "--out")
    run(*simulate, "healthy.h5", check=0, cwd=tmp_path)
    assert read_results(tmp_path / "healthy.h5").fixed_baseline.tolist() == [0]
    run(*simulate, "leaky.h5", "--set=leakage.internal_coefficient=1e-8", check=0, cwd=tmp_path)
    with h5py.File(tmp_path / "leaky.h5", "a") as file:
        assert file[names.FIXED_BASELINE][0] == names.NO_BASELINE
        file[names.FIXED_BASELINE][0] = file[names.MATCHED_BASELINE][0] = 0
    assert not Report(read_results(tmp_path / "leaky.h5")).has_baseline
    record = run_json("report", "leaky.h5", cwd=tmp_path)
    (row,) = record["rows"]
    assert row["delta_fixed_percent"] == row["delta_matched_percent"] == [None] * 5
    assert row["detail_rms_Pa"][1] > 0.0
    assert record["delta_not_known"]
