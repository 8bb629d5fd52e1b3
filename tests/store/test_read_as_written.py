"""What is read is what was written: rows carry their own labels and baselines."""

import json
import shutil

import h5py
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.runs import run_table
from hydrofdi.store.layout import names
from tests.conftest import run_hydrofdi, sweep_in

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
    assert not Analysis(read_results(path)).has_baseline


def test_a_healthy_run_by_itself_is_its_own_baseline(tmp_path):
    settings = ("--set=record.duration=1 s", "--out", "run.h5")
    assert run_hydrofdi("simulate", *settings, cwd=tmp_path).returncode == 0
    assert read_results(tmp_path / "run.h5").fixed_baseline.tolist() == [0]
