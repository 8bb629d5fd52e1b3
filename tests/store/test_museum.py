"""Files that earlier versions wrote, through the present report."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray

from tests.conftest import run_hydrofdi

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
