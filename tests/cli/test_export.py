"""``hydrofdi export``: signals that other programs read, and that hydrofdi reads again to the bit."""

import csv
import math

import numpy as np
import pandas
import pyarrow.parquet
import pytest
import scipy.io

import hydrofdi
from tests.commands import run, run_json

FORMS = ("csv", "parquet", "mat")


def numbers(*sources):
    records = run_json("measure", *sources, "--indicators", "dwt,ring_down,weak_rls,sliding")["records"]
    return [record["values"] for record in records]


def exported(source, out, *options, check=0):
    """Names of the files in a folder after an export."""
    run("export", source, "--out", out, *options, check=check)
    return sorted(file.name for file in out.iterdir())


@pytest.mark.parametrize("form", FORMS)
def test_what_is_exported_measures_as_its_source_to_the_last_bit_stored_or_simulated(
    small_sweep, tmp_path, form
):
    stored, again = tmp_path / "stored", tmp_path / "again"
    names = exported(small_sweep.directory, stored, "--format", form)
    assert exported(small_sweep.config, again, "--format", form) == names
    expected = numbers(small_sweep.directory)
    for folder in (stored, again):
        assert numbers(*sorted(folder.iterdir())) == expected
    position, identity = names[3].removesuffix(f".{form}").split("-")
    assert run_json("why", small_sweep.directory, identity)["position"] == int(position)


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """One simulated record in every form."""
    place = tmp_path_factory.mktemp("one")
    short, leaking = "record.duration=2 s", "leakage.internal_flow=0.2 L/min"
    run("simulate", "--set", short, "--set", leaking, "--out", place / "run.h5", check=0)
    for form in FORMS:
        run("export", place / "run.h5", "--out", place / f"run.{form}", check=0)
    return {form: place / f"run.{form}" for form in FORMS}


def exact_frame(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return pandas.DataFrame([[float(cell) for cell in row] for row in rows], columns=header)


def test_all_forms_hold_the_same_numbers_and_units_and_cause_no_remarks(one):
    raw = one["csv"].read_bytes()
    assert raw.startswith(b"time [s],P1 [Pa],P2 [Pa],")
    assert b"\r" not in raw
    frame, table = exact_frame(one["csv"]), pandas.read_parquet(one["parquet"])
    pandas.testing.assert_frame_equal(frame, table, check_exact=True)
    schema = pyarrow.parquet.read_schema(one["parquet"])
    stated = {title: title.partition("[")[2][:-1] for title in frame.columns}
    assert {field.name: field.metadata[b"units"].decode() for field in schema} == stated
    mat = scipy.io.loadmat(one["mat"], simplify_cells=True)
    assert mat["units"] == {title.split(" [")[0]: unit for title, unit in stated.items()}
    assert {*mat["units"]} >= {"time", "P1", "P2", "x", "v", "xv", "u"}
    assert scipy.io.loadmat(one["mat"])["P1"].shape == (1000, 1)
    for title in frame.columns:
        assert np.array_equal(mat[title.split(" [")[0]], frame[title])
    for form in FORMS:
        done = run_json("measure", one[form], "--indicators", "dwt,pressure_balance")
        assert done["records"][0]["status"] == "ok"
        assert run_json("inspect", one[form])["findings"] == {}


def test_channels_and_units_are_chosen(one, tmp_path):
    out = tmp_path / "few.csv"
    run("export", one["mat"], "--out", out, "--channels", "position,P2", "--unit", "bar,mm", check=0)
    few, whole = pandas.read_csv(out), pandas.read_csv(one["csv"])
    assert list(few.columns) == ["time [s]", "x [mm]", "P2 [bar]"]
    assert np.allclose(few["x [mm]"] / 1e3, whole["x [m]"], rtol=1e-14)
    assert np.allclose(few["P2 [bar]"] * 1e5, whole["P2 [Pa]"], rtol=1e-14)


def test_python_exports_what_the_command_does_frames_and_files_under_their_name(one, tmp_path):
    frame = exact_frame(one["csv"])
    for name, source in {"again": one["mat"], "frame": frame}.items():
        (file,) = hydrofdi.export(source, tmp_path / f"{name}.csv").files
        assert file.read_bytes() == one["csv"].read_bytes()
    with pytest.raises(hydrofdi.HydrofdiError, match="lpm"):
        hydrofdi.export(frame, tmp_path / "unit.csv", unit="lpm")
    (file,) = hydrofdi.export(one["csv"], tmp_path / "folder").files
    assert file.name == "0001-run.csv"


def test_runs_are_chosen_by_position_range_and_identity(small_sweep, tmp_path):
    everything = exported(small_sweep.directory, tmp_path / "all")
    runs = f"{everything[3].split('-')[1][:6]},0-1"
    some = [everything[place] for place in (0, 1, 3)]
    assert exported(small_sweep.directory, tmp_path / "some", "--runs", runs) == some
    assert exported(small_sweep.config, tmp_path / "made", "--runs", "2") == [everything[2]]


def test_missing_samples_stay_missing(tmp_path):
    (tmp_path / "rig.csv").write_text("time [s],P1 [bar]\n0,50\n0.1,\n0.2,51\n0.3,52\n")
    for form in FORMS:
        run("export", tmp_path / "rig.csv", "--out", tmp_path / f"out.{form}", check=0)
    assert (tmp_path / "out.csv").read_text().splitlines()[2] == "0.1,"
    assert math.isnan(scipy.io.loadmat(tmp_path / "out.mat")["P1"][1, 0])
    assert math.isnan(pandas.read_parquet(tmp_path / "out.parquet")["P1 [Pa]"][1])


def test_runs_that_fail_are_left_out_and_named(one_failed, tmp_path):
    done = run("export", one_failed.config, "--out", tmp_path / "out", check=1)
    assert "wrote 2 records" in done.stderr
    assert "left out 1 of 3 records; " in done.stderr
    assert sorted(file.name[:4] for file in (tmp_path / "out").iterdir()) == ["0000", "0002"]


@pytest.mark.parametrize("form", FORMS)
def test_files_of_others_are_left_alone(one, tmp_path, form):
    mine, theirs = tmp_path / f"mine.{form}", tmp_path / f"theirs.{form}"
    for channels in ("P1,P2", "P1"):
        run("export", one["csv"], "--out", mine, "--channels", channels, "--overwrite", check=0)
    assert [*run_json("inspect", mine)["channels"]] == ["chamber_1_pressure"]
    before = mine.read_bytes()
    theirs.write_text("a thesis")
    for options in ((), ("--overwrite",)):
        assert str(theirs) in run("export", one["csv"], "--out", theirs, *options, check=2).stderr
        assert theirs.read_text() == "a thesis"
        assert "input and the output" in run("export", mine, "--out", mine, *options, check=2).stderr
    run("export", one["csv"], "--out", mine, check=2)
    assert mine.read_bytes() == before


def test_a_folder_with_an_earlier_export_is_replaced_only_when_asked(small_sweep, tmp_path):
    out = tmp_path / "signals"
    first = exported(small_sweep.directory, out, "--runs", "0-2")
    (out / "0009-mine.csv").write_text("a thesis")
    (tmp_path / "short.csv").write_text("time [s],P1 [bar]\n0,1\n")
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    refused = run("export", small_sweep.directory, "--out", out, "--runs", "3", check=2)
    assert "contains an earlier export (3 files, such as 0000-" in refused.stderr
    run("export", tmp_path / "short.csv", "--out", out, "--overwrite", check=2)
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before
    kept = exported(small_sweep.directory, out, "--runs", "2-3", "--overwrite")
    assert {*kept} & {*before} == {first[2], "0009-mine.csv"}
    assert len(kept) == 3
    kept = exported(out / first[2], out, "--overwrite", "--channels", "P1")
    assert first[2] in kept, "input files are kept"
