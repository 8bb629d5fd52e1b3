"""What exists already: files of other programs stay, and no file of a folder is ignored."""

import h5py
import numpy as np
import pandas
import pytest
import scipy.io

import hydrofdi
from tests.commands import run, run_json

SHORT = ("--set", "record.duration=2 s")
LOGGED = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(100))


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
        ("measure", "{}"),
        ("report", "{}"),
        ("export", "{}", "--out", "exported"),
        ("train", "{}", "--direction", "rising", "--out", "detector.json"),
    ],
)
def test_a_folder_with_several_runs_is_refused_by_name(runs, tmp_path, words):
    refused = run(*(word.format(runs) for word in words), cwd=tmp_path, check=2)
    (line,) = refused.stderr.splitlines()
    assert "contains 2 files with records (run1.h5, run2.h5)" in line
    assert f"name the files, such as {runs / 'run1.h5'}" in line
    assert not list(tmp_path.iterdir())


def test_a_measured_file_beside_a_run_is_not_ignored(runs, tmp_path):
    (tmp_path / "run.h5").write_bytes((runs / "run1.h5").read_bytes())
    assert run_json("inspect", tmp_path)["records"] == 1
    (tmp_path / "rig.csv").write_text(LOGGED)
    assert "(run.h5, rig.csv)" in run("inspect", tmp_path, check=2).stderr


def test_the_folder_of_a_sweep_may_contain_other_files(small_sweep, runs, tmp_path):
    folder = tmp_path / "swept"
    run("sweep", small_sweep.config, "--out", folder, check=0)
    before = run_json("measure", folder)["records"]
    (folder / "a.h5").write_bytes((runs / "run1.h5").read_bytes())
    (folder / "rig.csv").write_text(LOGGED)
    assert run_json("measure", folder)["records"] == before


def test_a_run_is_stored_over_an_earlier_run_only(runs, tmp_path):
    own, foreign = tmp_path / "run.h5", tmp_path / "rig.h5"
    own.write_bytes((runs / "run1.h5").read_bytes())
    run("simulate", *SHORT, "--out", own, check=0)
    assert own.read_bytes() != (runs / "run1.h5").read_bytes()
    before = foreign_file(foreign)
    refused = run("simulate", *SHORT, "--out", foreign, check=2).stderr
    assert "is not an experiment file of hydrofdi and was not changed; choose another name" in refused
    with pytest.raises(hydrofdi.HydrofdiError, match="was not changed"):
        hydrofdi.simulate(duration="2 s").save(foreign)
    assert foreign.read_bytes() == before


def test_a_sweep_leaves_a_foreign_file_with_its_name(tmp_path):
    config = tmp_path / "rig.yaml"
    config.write_text("name: rig\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    (tmp_path / "out").mkdir()
    before = foreign_file(tmp_path / "out" / "rig.h5")
    assert "was not changed" in run("sweep", config, "--out", tmp_path / "out", check=2).stderr
    assert (tmp_path / "out" / "rig.h5").read_bytes() == before
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["rig.h5"]


def foreign_file(path):
    """An HDF5 file of another program."""
    with h5py.File(path, "w") as file:
        file["pressure"] = np.arange(5.0)
    return path.read_bytes()


@pytest.mark.parametrize("form", ["csv", "parquet", "mat"])
def test_an_export_replaces_a_file_only_when_asked(runs, tmp_path, form):
    target = tmp_path / f"rig.{form}"
    if form == "csv":
        target.write_text(LOGGED)
    elif form == "parquet":
        pandas.DataFrame({"time [s]": [0.0, 1.0], "mine": [1.0, 2.0]}).to_parquet(target)
    else:
        scipy.io.savemat(target, {"mine": np.ones(3)})
    before = target.read_bytes()
    refused = run("export", runs / "run1.h5", "--out", target, check=2).stderr
    assert f"{target}: already exists and was not changed" in refused
    assert "overwrite" in refused
    assert len(refused.splitlines()) == 1
    assert target.read_bytes() == before
    run("export", runs / "run1.h5", "--out", target, "--overwrite", check=0)
    assert run_json("inspect", target)["records"] == 1


REFUSED = "was not changed; choose another name"
RECORDING = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(2000))


def test_measure_never_replaces_the_recording_that_it_reads(tmp_path):
    (tmp_path / "own.csv").write_text(RECORDING)
    (tmp_path / "own.yaml").write_text("files: own.csv\ntime: {column: 'time [s]'}\n")
    for source in ("own.csv", "own.yaml"):
        assert REFUSED in run("measure", source, "--out", "own.csv", cwd=tmp_path, check=2).stderr
    assert (tmp_path / "own.csv").read_text() == RECORDING


@pytest.mark.parametrize("suffix", ["csv", "json", "parquet"])
def test_measure_replaces_its_own_table_and_no_foreign_file(tmp_path, suffix):
    (tmp_path / "rig.csv").write_text(RECORDING)
    out = tmp_path / f"out.{suffix}"
    measure = ("measure", "rig.csv", "--out", out, "--indicators")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    first = out.read_bytes()
    run(*measure, "pressure_statistics", cwd=tmp_path, check=0)
    assert out.read_bytes() != first
    foreign = first[:12] + b"another file"
    out.write_bytes(foreign)
    assert f"out.{suffix}: already exists" in run(*measure, "dwt", cwd=tmp_path, check=2).stderr
    assert out.read_bytes() == foreign
    out.write_bytes(b"")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    assert out.read_bytes() == first


def test_a_report_replaces_its_own_files_and_no_foreign_one(small_sweep, tmp_path):
    report = ("report", small_sweep.directory, "--out", tmp_path)
    run(*report, check=0)
    run(*report, check=0)
    figure = tmp_path / "sensitivity.png"
    figure.unlink()
    for suffix in ("md", "csv", "json", "html", "parquet"):
        foreign = tmp_path / f"small.{suffix}"
        before = foreign.read_bytes()
        foreign.write_text("# small\n\nNotes on the press.\n")
        assert REFUSED in run(*report, check=2).stderr
        assert foreign.read_text().endswith("press.\n")
        foreign.write_bytes(before)
    assert not figure.exists()


def test_a_page_replaces_an_earlier_page_and_no_foreign_one(small_sweep, tmp_path):
    page = tmp_path / "my.html"
    run("report", small_sweep.directory, "--html", page, check=0)
    run("report", small_sweep.directory, "--html", page, check=0)
    foreign = '<!DOCTYPE html>\n<html lang="en"><title>My press</title></html>\n'
    page.write_text(foreign)
    assert REFUSED in run("report", small_sweep.directory, "--html", page, check=2).stderr
    assert page.read_text() == foreign


@pytest.mark.long
def test_the_files_of_a_study_are_replaced_by_a_second_report(tmp_path):
    run("sweep", "detectability-smoke", "--out", tmp_path / "study", "--engine", "in-process", check=0)
    for _ in range(2):
        run("report", tmp_path / "study", "--out", tmp_path / "report", check=0)
