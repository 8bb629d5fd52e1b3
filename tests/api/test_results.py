"""`hydrofdi.sweep` and `hydrofdi.load`."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

import hydrofdi
from hydrofdi.store.reading import read_experiment
from tests.commands import run
from tests.conftest import SMALL

STUDY = {
    "name": "small",
    "record": {"duration": "2 s"},
    "sweep": {"grid": {"leakage.internal_coefficient": [0, 1e-8], "fluid.bulk_modulus": ["551 MPa", 827e6]}},
}


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return hydrofdi.sweep(STUDY, out=tmp_path_factory.mktemp("api") / "small", engine="in-process")


def test_a_mapping_asks_for_the_runs_of_a_file(swept, small_sweep):
    assert swept.file.name == "small.h5"
    stored = hydrofdi.load(small_sweep.directory)
    assert swept.data.columns["run_id"].tolist() == stored.data.columns["run_id"].tolist()
    assert repr(stored) == f"4 runs in {small_sweep.directory}: 4 ok"


def test_the_same_call_runs_nothing_again_and_keywords_win(swept, tmp_path):
    before = swept.file.read_bytes()
    hydrofdi.sweep(STUDY, out=str(swept.folder), engine="in-process")
    assert swept.file.read_bytes() == before
    file = tmp_path / "small.yaml"
    file.write_text(SMALL)
    shorter = hydrofdi.sweep(file, out=tmp_path / "out", engine="in-process", duration="1 s", workers=1)
    assert shorter.data.experiment.record.duration == 1.0


def test_the_dataset_has_all_runs_and_is_read_when_used(small_sweep):
    dataset = hydrofdi.load(str(small_sweep.directory)).dataset
    assert dict(dataset.sizes) | {"run": 4, "level": 5} == dict(dataset.sizes)
    assert not dataset.chamber_1_pressure._in_memory
    stored = read_experiment(small_sweep.file)
    np.testing.assert_array_equal(dataset.detail_rms, stored.columns["detail_rms"])
    dataset.close()


def test_report_table_and_figure_are_those_of_the_command(small_sweep):
    results = hydrofdi.load(small_sweep.file)
    told = run("report", small_sweep.directory, "--format", "markdown", check=0).stdout
    assert hydrofdi.load(small_sweep.directory).report() == told
    rows = run("report", small_sweep.directory, "--format", "csv", check=0).stdout.splitlines()
    assert results.table.columns == rows[0].split(",")
    assert len(results.table) == len(rows) - 1
    assert results.table["delta_fixed_percent"].dtype == float
    assert results.plot()._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(hydrofdi.HydrofdiError, match="did you mean 'sensitivity'"):
        results.plot("sensitivty")


def test_a_sweep_that_has_not_ended_has_a_table_and_no_dataset(small_sweep, tmp_path):
    folder = tmp_path / "unfinished"
    shutil.copytree(small_sweep.directory, folder)
    (folder / "small.h5").unlink()
    results = hydrofdi.load(folder)
    assert len(results.table)
    with pytest.raises(hydrofdi.HydrofdiError, match=r"hydrofdi collect"):
        _ = results.dataset


def test_workers_do_not_run_the_script_again(tmp_path):
    script = tmp_path / "study.py"
    script.write_text(f"import hydrofdi\nprint('once')\nprint(hydrofdi.sweep({STUDY!r}, workers=2))\n")
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=True
    )
    once, told = done.stdout.splitlines()
    assert once == "once"
    assert told.startswith("4 runs in results/small: 4 ok")


def test_results_have_the_warnings_of_the_plan(tmp_path):
    study = STUDY | {"sweep": {"grid": {"fluid.bulk_modulus": ["0.5 GPa", 0.7]}}}
    planned = hydrofdi.plan(study, out=tmp_path / "small").warnings
    swept = hydrofdi.sweep(study, out=tmp_path / "small", engine="in-process")
    assert any("0.7 Pa is far below" in warning for warning in swept.warnings)
    assert swept.warnings == planned
    assert hydrofdi.load(tmp_path / "small").warnings == planned
    assert f"{len(planned)} warnings" in repr(swept)


def test_runs_that_have_not_settled_are_not_called_ok(tmp_path):
    oils = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    study = {"name": "short", "record": {"duration": "4 s"}, "sweep": {"grid": oils}}
    found = hydrofdi.sweep(study, out=tmp_path / "short", engine="in-process")
    assert found.verdicts == found.summary.verdicts == {"unsettled": 2}
    assert "2 done, 2 unsettled;" in repr(found)
    assert " ok" not in repr(found)


STUDY_COORDINATES = {
    "name": "told",
    "record": {"duration": "2 s"},
    "study": {
        "population": {"over": {"fluid.bulk_modulus": {"uniform": "±5 %"}}},
        "healthy": {"fit": 3, "test": 2, "shift": 2},
        "faults": {"leakage.internal_flow": ["0.1 L/min", "0.5 L/min"], "each": 2, "fit": 1},
        "shifts": {"stiffer": {"fluid.bulk_modulus": "1 GPa"}},
    },
}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("told") / "told"
    return hydrofdi.sweep(STUDY_COORDINATES, out=folder, engine="in-process").dataset


def test_each_run_has_the_population_that_its_parameters_show(dataset):
    assert dataset.population.dims == ("run",)
    leaking = dataset.internal_leakage_level.values * 60e3
    for name, flow in (("0.1 L/min", 0.1), ("0.5 L/min", 0.5)):
        assert leaking[dataset.population == name] == pytest.approx([flow] * 3)
    is_stiff = np.isclose(dataset.bulk_modulus, 1e9)
    np.testing.assert_array_equal(dataset.population == "stiffer", is_stiff)
    kinds = {"healthy": 5, "fault": 6, "shift": 2}
    assert {kind: int((dataset.population_kind == kind).sum()) for kind in kinds} == kinds


def test_fit_records_are_told_from_test_records(dataset):
    counts = dataset.is_fit.groupby("population").sum()
    assert counts.to_series().to_dict() == {"healthy": 3, "0.1 L/min": 1, "0.5 L/min": 1, "stiffer": 0}


def test_a_sweep_without_a_study_has_no_populations(small_sweep):
    assert "population" not in hydrofdi.load(small_sweep.directory).dataset.coords
