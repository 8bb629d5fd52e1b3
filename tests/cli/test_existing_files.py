"""What exists already: files of other programs stay, and no file of a folder is ignored."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
import typer.main

import hydrofdi
from hydrofdi.cli.app import application
from hydrofdi.detectors.configuration import setting_keys
from hydrofdi.tables.table import Column, Table
from tests.commands import run, run_hydrofdi, run_json

SHORT = ("--set", "record.duration=2 s")
LOGGED = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(1000))


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
    ["inspect {}", "report {}", "export {} --out exported", "train {} --direction rising --out d.json"],
)
def test_a_folder_with_several_runs_is_refused_by_name(runs, tmp_path, words):
    refused = run(*words.format(runs).split(), cwd=tmp_path, check=2)
    (line,) = refused.stderr.splitlines()
    assert str(runs / "run1.h5") in line
    assert not list(tmp_path.iterdir())


def test_other_files_may_stand_beside_a_sweep_which_is_collected_anew_but_not_beside_a_run(
    small_sweep, runs, tmp_path
):
    folder = tmp_path / "swept"
    shutil.copytree(small_sweep.directory, folder)
    before = run_json("measure", folder)["records"]
    for place in (folder / "a.h5", tmp_path / "run.h5"):
        shutil.copy(runs / "run1.h5", place)
    (folder / "rig.csv").write_text(LOGGED)
    assert run_json("measure", folder)["records"] == before
    (folder / "small.h5").unlink()
    built = {"file": str(folder / "small.h5"), "planned": 4, "missing": 0, "failed": 0}
    assert run_json("collect", folder) == built
    assert run_json("measure", folder)["records"] == before
    shutil.rmtree(folder)
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
        file["pressure"] = range(5)
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
    figure, page = tmp_path / "sensitivity.png", tmp_path / "small.html"
    for _ in range(2):
        run(*report, check=0)
    figure.unlink()
    for suffix in ("md", "csv", "json", "html", "parquet"):
        file = tmp_path / f"small.{suffix}"
        own = file.read_bytes()
        file.write_text("# small\n\nNotes on the press.\n")
        run(*report, check=2)
        assert file.read_text().endswith("press.\n")
        file.write_bytes(own)
    assert not figure.exists()
    page.write_text("<!DOCTYPE html>\n<title>My press</title></html>\n")
    run("report", small_sweep.directory, "--html", page, check=2)
    assert "My press" in page.read_text()


def test_a_row_that_does_not_exist_is_named(small_sweep):
    (line,) = run("why", small_sweep.directory, "7", check=2).stderr.splitlines()
    assert "no row 7" in line


def test_a_parted_table_shows_every_cell_whole_under_its_header_and_acts_on_no_terminal():
    numbers = (
        Column(f"number {n}", [f"{run}.{n}2345" for run in range(3)], title=f"number {n} [unit]")
        for n in range(9)
    )
    table = Table((Column("run", ["r0", "a\x1b[31mred\x07", "r2"], is_text=True), *numbers))
    for width in (20, 60, 200):
        text = "\n".join(table.lines(width))
        assert all(f"{run}.{column}2345" in text for run in range(3) for column in range(9))
        assert all(f"number {column}" in text for column in range(9))
        assert max(map(len, text.splitlines())) <= width
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", repr(table))


def test_h_is_help_and_every_plain_setting_of_a_detector_is_an_option_of_train():
    assert run_hydrofdi("sweep", "-h").stdout == run_hydrofdi("sweep", "--help").stdout != ""
    command = typer.main.get_command(application(["train"])).commands["train"]
    options = {parameter.name for parameter in command.params}
    assert setting_keys().keys() - options == {"options", "indicators", "score"}


SCRIPT = Path(sys.executable).parent / "hydrofdi"


@pytest.mark.skipif(not SCRIPT.exists(), reason="the command is not installed: make install")
def test_the_shell_completes_commands():
    asked = {"_HYDROFDI_COMPLETE": "complete_bash", "COMP_WORDS": "hydrofdi sw", "COMP_CWORD": "1"}
    done = subprocess.run([SCRIPT], env=os.environ | asked, capture_output=True, text=True, timeout=60)
    assert (done.stdout.split(), done.stderr) == (["sweep"], "")
