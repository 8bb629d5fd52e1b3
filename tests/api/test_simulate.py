"""`hydrofdi.simulate`: keywords, errors, and what a run gives."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

import hydrofdi
from hydrofdi.store.experiment_file import read_experiment
from tests.commands import run, run_json

SHORT = {"duration": "2 s"}


@pytest.fixture(scope="module")
def leaking():
    return hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", **SHORT)


def test_files_mappings_and_keywords_ask_for_the_same_run(tmp_path, leaking):
    file = tmp_path / "mine.yaml"
    file.write_text("fluid: {bulk_modulus: 689 MPa}\nrecord: {duration: 2 s}\n")
    section = {"fluid": {"bulk_modulus": "689 MPa"}, "record": {"duration": np.float64(2.0)}}
    same = [
        hydrofdi.simulate(file, internal_flow="0.2 L/min"),
        hydrofdi.simulate(str(file), leakage__internal_flow=0.2e-3 / 60.0),
        hydrofdi.simulate(section, **{"leakage.internal_flow": "0.2 L/min"}),
        hydrofdi.simulate(fluid={"bulk_modulus": "689 MPa"}, internal_flow="0.2 L/min", **SHORT),
        hydrofdi.simulate(hydrofdi.load_experiment(file, {"leakage.internal_flow": "0.2 L/min"})),
    ]
    assert {each.run_id for each in same} == {leaking.run_id}
    assert section["record"] == {"duration": 2.0}


def test_a_run_says_what_the_command_says_and_is_written_and_read_again(leaking, tmp_path):
    settings = ["fluid.bulk_modulus=689 MPa", "leakage.internal_flow=0.2 L/min", "record.duration=2 s"]
    printed = run_json("simulate", *(word for each in settings for word in ("--set", each)))
    assert leaking.to_dict() == printed
    assert leaking.features["dwt.d2"] == printed["detail_rms_Pa"][1]
    assert (leaking.status, leaking.message) == ("ok", "")
    leaking.save(tmp_path / "run.h5")
    assert read_experiment(tmp_path / "run.h5").columns["run_id"][0] == leaking.run_id
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(hydrofdi.HydrofdiError):
        leaking.save(str(tmp_path / "notes.txt"))


def test_a_run_is_a_dataset_with_units_a_frame_and_a_page(leaking):
    data = leaking.to_xarray()
    assert (data.chamber_1_pressure.dims, data.detail_rms.dims) == (("time",), ("level",))
    assert data.level.values.tolist() == [1, 2, 3, 4, 5]
    assert (data.time.attrs["units"], data.internal_leakage_flow.attrs["units"]) == ("s", "m3 s-1")
    assert all({"units", "long_name"} <= each.attrs.keys() for each in data.data_vars.values())
    flow = np.abs(data.internal_leakage_flow).mean().item()
    np.testing.assert_allclose(flow, data.mean_internal_leakage_flow, rtol=0.2)
    assert data.attrs["run_id"] == leaking.run_id
    same, own = hydrofdi.measure(leaking.to_pandas(), "dwt"), hydrofdi.measure(leaking, "dwt")
    np.testing.assert_allclose(same["dwt.d2"], own["dwt.d2"], rtol=1e-12)
    assert "dwt.d2" in leaking._repr_html_()
    assert leaking.plot()._repr_png_().startswith(b"\x89PNG")
    volterra = hydrofdi.simulate(indicators=["dwt", "volterra"], **SHORT)
    assert volterra.to_xarray()["volterra.coefficients"].dims == ("volterra.term",)
    assert "volterra.coefficients" not in volterra.features


def test_without_the_extra_one_sentence_says_what_to_install(leaking, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(hydrofdi.HydrofdiError, match=r"^xarray is not installed: .*hydrofdi\[notebook\]"):
        leaking.to_xarray()


STUDY = {
    "name": "small",
    "record": {"duration": "2 s"},
    "sweep": {"grid": {"leakage.internal_coefficient": [0, 1e-8], "fluid.bulk_modulus": ["551 MPa", 827e6]}},
}


def test_the_dataset_has_all_runs_and_is_read_when_used(small_sweep, tmp_path):
    dataset = hydrofdi.load(str(small_sweep.directory)).dataset
    assert dict(dataset.sizes) | {"run": 4, "level": 5} == dict(dataset.sizes)
    assert not dataset.chamber_1_pressure._in_memory
    stored = read_experiment(small_sweep.file)
    np.testing.assert_array_equal(dataset.detail_rms, stored.columns["detail_rms"])
    dataset.close()
    folder = tmp_path / "unfinished"
    shutil.copytree(small_sweep.directory, folder)
    (folder / "small.h5").unlink()
    results = hydrofdi.load(folder)
    assert len(results.table)
    with pytest.raises(hydrofdi.HydrofdiError, match=r"hydrofdi collect"):
        _ = results.dataset


def test_report_table_and_figure_are_those_of_the_command(small_sweep):
    results, report = hydrofdi.load(small_sweep.file), ("report", small_sweep.directory, "--format")
    assert results.report() == run(*report, "markdown", check=0).stdout
    rows = run(*report, "csv", check=0).stdout.splitlines()
    assert results.table.columns == rows[0].split(",")
    assert len(results.table) == len(rows) - 1
    assert results.plot()._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(hydrofdi.HydrofdiError, match="did you mean 'sensitivity'"):
        results.plot("sensitivty")


def test_workers_do_not_run_the_script_again(tmp_path):
    script = tmp_path / "study.py"
    script.write_text(f"import hydrofdi\nprint('once')\nprint(hydrofdi.sweep({STUDY!r}, workers=2))\n")
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=True
    )
    once, told = done.stdout.splitlines()
    assert once == "once"
    assert told.startswith("4 runs in results/small: 4 ok")


def test_results_have_the_warnings_of_the_plan_and_the_verdicts(tmp_path):
    oils = {"fluid.bulk_modulus": ["0.5 GPa", "0.7 Pa", "689 MPa"]}
    study = {"name": "small", "record": {"duration": "4 s"}, "sweep": {"grid": oils}}
    planned = hydrofdi.plan(study, out=tmp_path / "small").warnings
    swept = hydrofdi.sweep(study, out=tmp_path / "small", engine="in-process")
    assert any("0.7 Pa is far below" in warning for warning in swept.warnings)
    assert swept.warnings == planned
    assert hydrofdi.load(tmp_path / "small").warnings == planned
    assert f"{len(planned)} warnings" in repr(swept)
    assert swept.verdicts == swept.summary.verdicts
    assert swept.verdicts["unsettled"] == 3
    assert " ok" not in repr(swept)


POPULATIONS = {
    "name": "told",
    "record": {"duration": "2 s"},
    "study": {
        "population": {"over": {"fluid.bulk_modulus": {"uniform": "±5 %"}}},
        "healthy": {"fit": 3, "test": 2, "shift": 2},
        "faults": {"leakage.internal_flow": ["0.1 L/min", "0.5 L/min"], "each": 2, "fit": 1},
        "shifts": {"stiffer": {"fluid.bulk_modulus": "1 GPa"}},
    },
}


def test_each_run_has_the_population_and_the_role_that_its_parameters_show(tmp_path):
    told = hydrofdi.sweep(POPULATIONS, out=tmp_path / "told", engine="in-process")
    dataset = told.dataset
    assert dataset.population.dims == ("run",)
    leaking = dataset.internal_leakage_level.values * 60e3
    for name, flow in (("0.1 L/min", 0.1), ("0.5 L/min", 0.5)):
        assert leaking[dataset.population == name] == pytest.approx([flow] * 3)
    is_stiff = np.isclose(dataset.bulk_modulus, 1e9)
    np.testing.assert_array_equal(dataset.population == "stiffer", is_stiff)
    kinds = {"healthy": 5, "fault": 6, "shift": 2}
    assert {kind: int((dataset.population_kind == kind).sum()) for kind in kinds} == kinds
    counts = dataset.is_fit.groupby("population").sum()
    assert counts.to_series().to_dict() == {"healthy": 3, "0.1 L/min": 1, "0.5 L/min": 1, "stiffer": 0}
    roles = [hydrofdi.why(told, row).role for row in (0, int(np.flatnonzero(is_stiff)[0]))]
    assert roles == ["healthy, fit record", "shift stiffer, test record"]
