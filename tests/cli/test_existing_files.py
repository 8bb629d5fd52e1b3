"""What exists already: files of other programs stay, and no file of a folder is ignored."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import typer.main

import hydrofdi
from hydrofdi.cli.app import application
from hydrofdi.detectors.configuration import setting_keys
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.shards import content_digest
from hydrofdi.tables.table import Column, Table
from tests.commands import run, run_hydrofdi, run_json
from tests.conftest import sweep_in

SHORT = ("--set", "record.duration=2 s")
LOGGED = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(1000))


FORMS = ("md", "csv", "json", "html", "parquet")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder with two single runs."""
    folder = tmp_path_factory.mktemp("runs")
    for level in (1, 2):
        leak = f"leakage.internal_flow=0.{level} L/min"
        run("simulate", *SHORT, "--set", leak, "--out", folder / f"run{level}.h5", check=0)
    return folder


@pytest.mark.parametrize(
    "words",
    [
        ("inspect", "{}"),
        ("report", "{}"),
        ("export", "{}", "--out", "exported"),
        ("train", "{}", "--direction", "rising", "--out", "detector.json"),
    ],
)
def test_a_folder_with_several_runs_is_refused_by_name(runs, tmp_path, words):
    refused = run(*(word.format(runs) for word in words), cwd=tmp_path, check=2)
    (line,) = refused.stderr.splitlines()
    assert str(runs / "run1.h5") in line
    assert not list(tmp_path.iterdir())


def test_other_files_may_stand_beside_a_sweep_but_not_beside_a_run(small_sweep, runs, tmp_path):
    folder = tmp_path / "swept"
    run("sweep", small_sweep.config, "--out", folder, check=0)
    before = run_json("measure", folder)["records"]
    (folder / "a.h5").write_bytes((runs / "run1.h5").read_bytes())
    (folder / "rig.csv").write_text(LOGGED)
    assert run_json("measure", folder)["records"] == before
    (tmp_path / "run.h5").write_bytes((runs / "run1.h5").read_bytes())
    assert run_json("inspect", tmp_path)["records"] == 1
    (tmp_path / "rig.csv").write_text(LOGGED)
    run("inspect", tmp_path, check=2)


def test_a_run_or_a_sweep_is_stored_over_an_earlier_one_only(runs, tmp_path):
    own, foreign = tmp_path / "run.h5", tmp_path / "out" / "rig.h5"
    own.write_bytes((runs / "run1.h5").read_bytes())
    run("simulate", *SHORT, "--out", own, check=0)
    assert own.read_bytes() != (runs / "run1.h5").read_bytes()
    foreign.parent.mkdir()
    with h5py.File(foreign, "w") as file:
        file["pressure"] = np.arange(5.0)
    before = foreign.read_bytes()
    (tmp_path / "rig.yaml").write_text("name: rig\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    for command in (("simulate", *SHORT, "--out", foreign), ("sweep", "rig.yaml", "--out", "out")):
        assert "was not changed" in run(*command, cwd=tmp_path, check=2).stderr
    with pytest.raises(hydrofdi.HydrofdiError):
        hydrofdi.simulate(duration="2 s").save(foreign)
    assert foreign.read_bytes() == before
    assert [*foreign.parent.iterdir()] == [foreign]


@pytest.mark.parametrize("suffix", ["csv", "json", "parquet"])
def test_measure_replaces_its_own_table_and_no_foreign_file(tmp_path, suffix):
    (tmp_path / "rig.csv").write_text(LOGGED)
    out = tmp_path / f"out.{suffix}"
    measure = ("measure", "rig.csv", "--indicators", "pressure_statistics", "--out")
    run("measure", "rig.csv", "--out", out, cwd=tmp_path, check=0)
    first = out.read_bytes()
    run(*measure, out, cwd=tmp_path, check=0)
    own = out.read_bytes()
    assert own != first
    foreign = first[:12] + b"another file"
    out.write_bytes(foreign)
    run(*measure, out, cwd=tmp_path, check=2)
    assert out.read_bytes() == foreign
    out.write_bytes(b"")
    run(*measure, out, cwd=tmp_path, check=0)
    assert out.read_bytes() == own
    run(*measure, "rig.csv", cwd=tmp_path, check=2)
    assert (tmp_path / "rig.csv").read_text() == LOGGED


def test_a_report_replaces_its_own_files_and_no_foreign_one(small_sweep, tmp_path):
    report = ("report", small_sweep.directory, "--out", tmp_path)
    run(*report, check=0)
    before = {suffix: (tmp_path / f"small.{suffix}").read_bytes() for suffix in FORMS}
    run(*report, check=0)
    figure = tmp_path / "sensitivity.png"
    figure.unlink()
    for suffix, own in before.items():
        foreign = tmp_path / f"small.{suffix}"
        foreign.write_text("# small\n\nNotes on the press.\n")
        run(*report, check=2)
        assert foreign.read_text().endswith("press.\n")
        foreign.write_bytes(own)
    assert not figure.exists()
    page = ("report", small_sweep.directory, "--html", tmp_path / "small.html")
    (tmp_path / "small.html").write_text("<!DOCTYPE html>\n<title>My press</title></html>\n")
    run(*page, check=2)
    assert "My press" in (tmp_path / "small.html").read_text()


_STUDY = {"name": "asked", "record": {"duration": "4 s"}, "store": {"signals": "none"}}
_GRID = {"leakage.internal_coefficient": [0.0, 2e-9]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("why") / "out"
    noisy = {"pressure_1_sensor": {"noise": "5 kPa"}, "measurement": {"seed": 3}}
    hydrofdi.sweep(_STUDY | noisy | {"sweep": {"grid": _GRID}}, out=out, engine="in-process")
    return out


def test_why_finds_a_run_by_row_or_identity(folder):
    (line,) = run("why", folder, "4", check=2).stderr.splitlines()
    assert "no row 4" in line
    told = run_json("why", folder, "1")
    assert run_json("why", folder, told["run_id"])["run_id"] == told["run_id"]


_KEPT = Path(__file__).parent.parent / "museum" / "format_4_physics_3" / "kept"


def test_status_says_that_an_earlier_version_stored_the_runs(tmp_path):
    folder = tmp_path / "kept"
    shutil.copytree(_KEPT, folder)
    (shard,) = (folder / "shards").iterdir()
    with h5py.File(shard, "a") as file:
        file.attrs["physics_version"] = PHYSICS_VERSION - 1
    shard.rename(shard.with_stem(content_digest(shard)))
    assert run_json("status", folder)["earlier"] == 8


def test_collect_says_what_it_built(tmp_path):
    swept = sweep_in(tmp_path, "name: built\nrecord: {duration: 2 s}\n")
    file = swept.directory / "built.h5"
    file.unlink()
    collected = run_json("collect", swept.directory)
    assert collected == {"file": str(file), "planned": 1, "missing": 0, "failed": 0}
    assert file.exists()


SWEEP = "record: {duration: 6 s}\nsweep: {grid: {fluid.bulk_modulus: [551 MPa, 689.123 MPa]}}\n"


@pytest.mark.parametrize("width", [20, 60, 200])
def test_a_parted_table_shows_every_cell_whole_under_its_header(width):
    numbers = (
        Column(f"number {n}", [f"{run}.{n}2345" for run in range(3)], title=f"number {n} [unit]")
        for n in range(9)
    )
    table = Table((Column("run", ["r0", "r1", "r2"], is_text=True), *numbers))
    text = "\n".join(table.lines(width))
    assert all(f"{run}.{column}2345" in text for run in range(3) for column in range(9))
    assert all(f"number {column}" in text for column in range(9))
    assert max(map(len, text.splitlines())) <= width


def test_texts_from_outside_do_not_act_on_the_terminal():
    table = Table((Column("name", ["a\x1b[31mred\x07"], is_text=True),))
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", repr(table))


SCRIPT = Path(sys.executable).parent / "hydrofdi"


@pytest.mark.parametrize("command", [(), ("sweep",), ("measure",)])
def test_h_is_help(command):
    short, full = (run_hydrofdi(*command, option) for option in ("-h", "--help"))
    assert short.returncode == 0
    assert short.stdout == full.stdout


@pytest.mark.skipif(not SCRIPT.exists(), reason="the command is not installed: make install")
def test_the_shell_completes_commands():
    asked = {"_HYDROFDI_COMPLETE": "complete_bash", "COMP_WORDS": "hydrofdi sw", "COMP_CWORD": "1"}
    done = subprocess.run([SCRIPT], env=os.environ | asked, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["sweep"]
    assert not done.stderr


def test_every_plain_setting_of_a_detector_is_an_option_of_train():
    command = typer.main.get_command(application(["train"])).commands["train"]
    options = {parameter.name for parameter in command.params}
    assert setting_keys().keys() - options == {"options", "indicators", "score"}
