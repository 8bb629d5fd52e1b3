"""Sweeps that resume, clear leftovers, and refuse other settings."""

import shutil
from pathlib import Path

import h5py
import pytest

from tests.commands import run, run_json

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


@pytest.fixture
def swept(tmp_path):
    run("sweep", write_grid(tmp_path, 5), "--out", tmp_path / "out", "--workers", "2", check=0)
    return tmp_path


def test_a_grown_grid_computes_the_new_points_alone(swept):
    summary = run_json("sweep", write_grid(swept, 7), "--out", swept / "out")
    assert (summary["planned"], summary["completed"], summary["skipped"]) == (35, 10, 25)


def test_a_second_sweep_computes_nothing_and_leaves_the_file_alone(swept):
    file = swept / "out" / "grid.h5"
    before = file.read_bytes(), file.stat().st_mtime_ns
    assert run_json("sweep", write_grid(swept, 5), "--out", swept / "out")["completed"] == 0
    assert (file.read_bytes(), file.stat().st_mtime_ns) == before


def test_a_shrunk_grid_keeps_what_it_no_longer_asks_for(swept):
    run("sweep", write_grid(swept, 2), "--out", swept / "out", check=0)
    with h5py.File(swept / "out" / "grid.h5") as file:
        assert len(file["run"]) == 10
    assert run_json("sweep", write_grid(swept, 5), "--out", swept / "out")["completed"] == 0


def test_the_spelling_of_a_quantity_makes_no_other_run(swept):
    file = write_grid(swept, 5)
    file.write_text(file.read_text().replace("551 MPa", "551.0e6").replace("827 MPa", "0.827 GPa"))
    assert run_json("sweep", file, "--out", swept / "out")["completed"] == 0


def test_runs_without_signals_are_computed_again_when_signals_are_wanted(swept):
    file = write_grid(swept, 5, signals="pressures")
    plan = run_json("plan", file, "--out", swept / "out")
    assert plan["reasons"] == {"stored without the signals or the precision that the request needs": 25}
    assert run_json("sweep", file, "--out", swept / "out")["completed"] == 25
    assert run_json("sweep", write_grid(swept, 5), "--out", swept / "out")["completed"] == 0


def test_a_plan_writes_nothing_and_says_why(swept):
    file = write_grid(swept, 6)
    before = sorted(path.name for path in swept.rglob("*"))
    plan = run_json("plan", file, "--out", swept / "out")
    assert (plan["planned"], plan["stored"], plan["missing"], plan["reasons"]) == (30, 25, 5, {"new": 5})
    assert plan["first_point"] == {"leakage.internal_coefficient": 0.0, "fluid.bulk_modulus": 551e6}
    assert plan["last_point"] == {"leakage.internal_coefficient": 5e-9, "fluid.bulk_modulus": 827e6}
    assert 0.0 < plan["predicted_seconds"] < plan["predicted_seconds_most"]
    assert sorted(path.name for path in swept.rglob("*")) == before


def test_results_of_another_physics_version_are_computed_again_and_the_plan_says_so(swept):
    out = swept / "out"
    index = (out / "index.json").read_text()
    assert '"physics_version":' in index
    code = (
        "import sys; import hydrofdi.physics as p; p.PHYSICS_VERSION += 1;"
        "from hydrofdi.cli.app import main; sys.argv[0] = 'hydrofdi'; main()"
    )
    import json
    import subprocess
    import sys

    done = subprocess.run(
        [sys.executable, "-c", code, "plan", write_grid(swept, 5), "--out", out, "--json"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    (reason,) = json.loads(done.stdout)["reasons"]
    assert reason.startswith("physics version changed")


def test_a_damaged_shard_is_named_and_its_runs_alone_are_computed_again(swept):
    out = swept / "out"
    whole = (out / "grid.h5").read_bytes()
    shards = sorted((out / "shards").glob("*.h5"))
    assert len(shards) > 1
    content = bytearray(shards[0].read_bytes())
    content[len(content) // 2] ^= 0xFF
    shards[0].write_bytes(content)
    faults = run_json("verify", out, check=1)["faults"]
    assert any(shards[0].name in fault for fault in faults)
    plan = run_json("plan", write_grid(swept, 5), "--out", out)
    assert plan["reasons"] == {"its shard is damaged": plan["missing"]}
    assert 0 < plan["missing"] < 25
    assert run_json("sweep", write_grid(swept, 5), "--out", out)["completed"] == plan["missing"]
    assert run_json("verify", out)["sound"]
    assert (out / "grid.h5").read_bytes() == whole


def test_the_experiment_file_can_be_built_again_from_the_shards(swept):
    out = swept / "out"
    whole = (out / "grid.h5").read_bytes()
    before = run("report", out, "--format", "csv", check=0).stdout
    (out / "grid.h5").unlink()
    (out / "index.json").unlink()
    without_file = run("report", out, "--format", "csv", check=0).stdout
    assert without_file == before
    run("collect", out, check=0)
    assert (out / "grid.h5").read_bytes() == whole


def test_an_unfinished_experiment_reports_with_holes(swept):
    out = swept / "out"
    shards = sorted((out / "shards").glob("*.h5"))
    shards[0].unlink()
    run("collect", out, check=0)
    status = run_json("status", out)
    assert status["missing"] == status["statuses"]["missing"] > 0
    rows = run_json("report", out)["rows"]
    assert {row["status"] for row in rows} == {"ok", "missing"}
    assert all((row["detail_rms_Pa"][0] is None) == (row["status"] == "missing") for row in rows)


def test_workers_and_batches_leave_no_trace_in_the_experiment_file(tmp_path):
    files = []
    for engine in (["--workers", "1"], ["--workers", "3"], ["--engine", "in-process"]):
        out = tmp_path / engine[-1] / "grid"
        run("sweep", write_grid(tmp_path, 5, signals="all"), "--out", out, *engine, check=0)
        files.append((out / "grid.h5").read_bytes())
    assert files[0] == files[1] == files[2]


def test_why_shows_differences_from_the_baseline_and_rerun_finds_the_same_bits(swept):
    out = swept / "out"
    reported = run_json("why", out, "7")
    assert reported["differences"] == {
        "fluid.bulk_modulus": [551e6, 689e6], "leakage.internal_coefficient": [0.0, 1e-9],
    }  # fmt: skip
    assert reported["status"] == "ok"
    assert reported["provenance"]["libraries"]["numpy"]
    assert run_json("rerun", out, reported["run_id"][:8]) == {
        "run_id": reported["run_id"], "same_bits": True, "differing": [],
    }  # fmt: skip
    assert "no run" in run("why", out, "zzzz", check=2).stderr


def test_a_changed_result_is_found_by_rerun(swept):
    out = swept / "out"
    run_id = run_json("why", out, "0")["run_id"]
    (shard,) = [path for path in (out / "shards").glob("*.h5") if run_id in _run_ids(path)]
    copy = out / "copy.h5"
    shutil.copy(shard, copy)
    with h5py.File(copy, "r+") as file:
        file["dwt.d1"][_run_ids(copy).index(run_id)] += 1e-9
    from hydrofdi.store.shard import content_digest

    copy.rename(out / "shards" / f"{content_digest(copy)}.h5")
    shard.unlink()
    assert run_json("rerun", out, run_id, check=1)["differing"] == ["dwt.d1"]


def _run_ids(path):
    with h5py.File(path) as file:
        return list(file["run_id"].asstr()[:])


def test_compression_and_single_precision_change_the_size_alone(tmp_path):
    sizes, values = {}, {}
    for setting in ("compression=none", "compression=gzip", "compression=lzf", "dtype=float32"):
        out = tmp_path / setting / "grid"
        grid = write_grid(tmp_path, 1, signals="pressures")
        run("sweep", grid, "--out", out, "--set", f"store.{setting}", check=0)
        with h5py.File(out / "grid.h5") as file:
            sizes[setting] = (out / "grid.h5").stat().st_size
            values[setting] = file["chamber_1_pressure"][:]
            assert file["detail_rms"].dtype == "float64"
    assert (values["compression=none"] == values["compression=gzip"]).all()
    assert (values["compression=none"] == values["compression=lzf"]).all()
    assert (values["compression=none"].astype("float32") == values["dtype=float32"]).all()
    assert sizes["compression=gzip"] < sizes["compression=none"] > sizes["dtype=float32"]


def test_a_folder_that_holds_another_experiment_is_left_alone(swept):
    other = swept / "other.yaml"
    other.write_text("name: other\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    reported = run("sweep", other, "--out", swept / "out", check=2).stderr
    assert "contains the experiment 'grid', not 'other'" in reported
    assert run_json("status", swept / "out")["planned"] == 25


def test_a_sweep_without_missing_runs_removes_half_written_files_too(tmp_path):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 2 s}\n")
    sweep = ("sweep", tmp_path / "few.yaml", "--out", tmp_path / "out", "--engine", "in-process")
    run(*sweep, check=0)
    leftover = tmp_path / "out" / ".few.h5.1.part"
    leftover.write_bytes(b"half")
    run(*sweep, check=0)
    assert not leftover.exists()


STUDY = {"name": "press", "record": {"duration": "2 s"}}
TEXT = "name: press\nrecord: {duration: 2 s}\n"
SHOWED = " than before; earlier runs are kept"


def sweep(folder: Path, *settings: str) -> str:
    options = [word for setting in settings for word in ("--set", setting)]
    return run("sweep", "press.yaml", "--engine", "in-process", *options, cwd=folder).stderr


def test_it_names_the_settings_that_differ_from_those_shown_until_now(tmp_path) -> None:
    (tmp_path / "press.yaml").write_text(TEXT)
    assert SHOWED not in sweep(tmp_path)
    assert SHOWED not in sweep(tmp_path)
    assert f"another supply.pressure{SHOWED}" in sweep(tmp_path, "supply.pressure=160 bar")
    assert SHOWED not in sweep(tmp_path, "supply.pressure=16 MPa")
    back = sweep(tmp_path)
    assert f"another supply.pressure{SHOWED}" in back
    assert "0 computed, 1 stored before" in back
    assert SHOWED not in sweep(tmp_path)
