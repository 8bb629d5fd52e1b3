"""Sweeps that resume, clear leftovers, and refuse other settings."""

import json
import shutil
import subprocess
import sys

import h5py
import pytest

from hydrofdi.store.shards import content_digest
from tests.commands import run, run_json
from tests.runner.processes import shards

GRID = """\
name: grid
record: {{duration: 2 s}}
store: {{signals: {signals}}}
sweep:
  grid:
    leakage.internal_coefficient: [{coefficients}]
    fluid.bulk_modulus: [551 MPa, 600e6, "689 MPa", 750000000, 827 MPa]
"""


def write_grid(folder, count, signals="none"):
    file = folder / "grid.yaml"
    coefficients = ", ".join(f"{k}e-9" for k in range(count))
    file.write_text(GRID.format(coefficients=coefficients, signals=signals))
    return file


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """25 runs without signals; to be read only."""
    folder = tmp_path_factory.mktemp("whole")
    run("sweep", write_grid(folder, 5), "--out", folder / "out", "--workers", "2", check=0)
    return folder / "out"


@pytest.fixture
def out(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "out")


def sweep(file, out):
    return run_json("sweep", file, "--out", out, "--engine", "in-process")


def test_what_is_stored_is_not_computed_again_and_a_plan_writes_nothing(out, tmp_path):
    stored, file = out / "grid.h5", write_grid(tmp_path, 5)
    before = stored.read_bytes(), stored.stat().st_mtime_ns
    assert sweep(file, out)["completed"] == 0
    file.write_text(file.read_text().replace("551 MPa", "551.0e6").replace("827 MPa", "0.827 GPa"))
    assert sweep(file, out)["completed"] == 0
    files = sorted(out.rglob("*"))
    plan = run_json("plan", write_grid(tmp_path, 7), "--out", out)
    assert (plan["planned"], plan["stored"], plan["missing"], plan["reasons"]) == (35, 25, 10, {"new": 10})
    assert 0.0 < plan["predicted_seconds"] < plan["predicted_seconds_most"]
    assert (stored.read_bytes(), stored.stat().st_mtime_ns, sorted(out.rglob("*"))) == (*before, files)
    grown = sweep(file, out)
    assert (grown["planned"], grown["completed"], grown["skipped"]) == (35, 10, 25)
    sweep(write_grid(tmp_path, 2), out)
    with h5py.File(stored) as data:
        assert len(data["run"]) == 10
    plan = run_json("plan", write_grid(tmp_path, 5, signals="pressures"), "--out", out)
    assert plan["reasons"] == {"stored without the signals or the precision that the request needs": 25}
    assert sweep(file, out)["completed"] == 25
    assert sweep(write_grid(tmp_path, 5), out)["completed"] == 0


def test_results_of_another_physics_version_are_computed_again_and_the_plan_says_so(whole, tmp_path):
    code = (
        "import sys; import hydrofdi.physics as p; p.PHYSICS_VERSION += 1;"
        "from hydrofdi.cli.app import main; sys.argv[0] = 'hydrofdi'; main()"
    )
    command = [sys.executable, "-c", code, "plan", write_grid(tmp_path, 5), "--out", whole, "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (reason,) = json.loads(done.stdout)["reasons"]
    assert reason.startswith("physics version changed")


def flipped(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 0xFF]) + content[middle + 1 :]


@pytest.mark.parametrize("damage", [flipped, lambda content: content[:3000]], ids=["flipped", "cut"])
def test_a_damaged_shard_is_named_and_its_runs_alone_are_computed_again(whole, out, tmp_path, damage):
    file, (shard, *others) = write_grid(tmp_path, 5), shards(out)
    assert others
    shard.write_bytes(damage(shard.read_bytes()))
    (out / "grid.h5").write_bytes(b"")
    assert any(shard.name in fault for fault in run_json("verify", out, check=1)["faults"])
    status = run_json("status", out, check=1)
    assert [shard.name in fault for fault in status["damaged"]] == [True]
    plan = run_json("plan", file, "--out", out)
    assert plan["reasons"] == {"its shard is damaged": plan["missing"]}
    assert 0 < plan["missing"] == status["missing"] < 25
    assert sweep(file, out)["completed"] == plan["missing"]
    assert run_json("verify", out)["sound"]
    assert (out / "grid.h5").read_bytes() == (whole / "grid.h5").read_bytes()


def test_the_experiment_file_can_be_built_again_from_the_shards_with_holes_for_lost_ones(whole, out):
    (out / "grid.h5").unlink()
    (out / "index.json").unlink()
    reported, without_file = (run("report", each, "--format", "csv").stdout for each in (whole, out))
    assert without_file == reported
    run("collect", out, check=0)
    assert (out / "grid.h5").read_bytes() == (whole / "grid.h5").read_bytes()
    shards(out)[0].unlink()
    run("collect", out, check=0)
    status = run_json("status", out)
    assert status["missing"] == status["statuses"]["missing"] > 0
    rows = run_json("report", out)["rows"]
    assert {row["status"] for row in rows} == {"ok", "missing"}
    assert all((row["detail_rms_Pa"][0] is None) == (row["status"] == "missing") for row in rows)


def _run_ids(path):
    with h5py.File(path) as file:
        return list(file["run_id"].asstr()[:])


def test_why_shows_differences_from_the_baseline_and_rerun_finds_changed_bits(out):
    reported = run_json("why", out, "7")
    assert reported["differences"] == {
        "fluid.bulk_modulus": [551e6, 689e6], "leakage.internal_coefficient": [0.0, 1e-9],
    }  # fmt: skip
    assert reported["status"] == "ok"
    assert reported["provenance"]["libraries"]["numpy"]
    run_id = reported["run_id"]
    found = {"run_id": run_id, "same_bits": True, "differing": []}
    assert run_json("rerun", out, run_id[:8]) == found
    (shard,) = [path for path in shards(out) if run_id in _run_ids(path)]
    with h5py.File(shard, "r+") as file:
        file["dwt.d1"][_run_ids(shard).index(run_id)] += 1e-9
    shard.rename(shard.with_stem(content_digest(shard)))
    assert run_json("rerun", out, run_id, check=1)["differing"] == ["dwt.d1"]


def test_compression_and_single_precision_change_the_size_alone(tmp_path):
    sizes, values = {}, {}
    for setting in ("compression=none", "compression=gzip", "compression=lzf", "dtype=float32"):
        folder = tmp_path / setting / "grid"
        grid = write_grid(tmp_path, 1, signals="pressures")
        run("sweep", grid, "--out", folder, "--engine", "in-process", "--set", f"store.{setting}", check=0)
        with h5py.File(folder / "grid.h5") as file:
            sizes[setting] = (folder / "grid.h5").stat().st_size
            values[setting] = file["chamber_1_pressure"][:]
            assert file["detail_rms"].dtype == "float64"
    exact, single = values["compression=none"], values.pop("dtype=float32")
    assert all((each == exact).all() for each in values.values())
    assert (exact.astype("float32") == single).all()
    assert sizes["compression=gzip"] < sizes["compression=none"] > sizes["dtype=float32"]


def test_half_written_files_are_removed_and_runs_of_other_settings_and_experiments_kept(whole, tmp_path):
    (tmp_path / "press.yaml").write_text("name: press\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    run("sweep", tmp_path / "press.yaml", "--out", whole, check=2)
    assert run("status", whole).stdout == "25 planned, 25 done, 0 failed, 0 missing (25 ok)\n"

    def told(*options):
        return run("sweep", "press.yaml", "--engine", "in-process", *options, cwd=tmp_path, check=0).stderr

    told()
    leftover = tmp_path / "results" / "press" / ".press.h5.1.part"
    leftover.write_bytes(b"half")
    assert "1 stored before" in told()
    assert not leftover.exists()
    assert "1 computed" in told("--set", "supply.pressure=160 bar")
    assert "0 computed, 1 stored before" in told()
