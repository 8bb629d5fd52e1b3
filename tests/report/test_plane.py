"""A grid over two parameters: its matrix, its heat maps, its cube, and its tables for papers."""

import csv
import shutil

import h5py
import numpy as np
import pytest
import xarray

import hydrofdi as package
from hydrofdi.errors import ReportError, UnknownNameError
from hydrofdi.store.names import coordinate
from tests.commands import run, run_json
from tests.report.rows import check_golden

AXES = ("--grid", "EBM=500MPa:900MPa:9", "--grid", "K_i=0:8e-9:9", "--name", "mine")
SHORT = ("--set", "duration=4 s", "--engine", "in-process")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plane")
    run("sweep", *AXES, *SHORT, cwd=folder, check=0)
    return folder


@pytest.fixture(scope="module")
def results(folder):
    return package.load(folder / "results/mine")


@pytest.mark.parametrize("form", ["text", "latex"])
def test_a_grid_is_reported_as_a_matrix(folder, form, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run("report", "results/mine", "--format", form, cwd=folder).stdout
    check_golden(f"matrix.{form}", text)
    assert form != "text" or len(text.splitlines()) <= 24


def test_each_cell_is_the_change_of_its_run_and_the_baseline_is_marked_where_it_is(results):
    plane, cube = results.composed.plane, results.grid()
    for level in range(5):
        matrix = plane.matrix(plane.features[level])
        np.testing.assert_array_equal(matrix, cube.delta.sel(level=level + 1).transpose("K_i", "EBM"))
    row, column = plane.baseline
    assert (row, 500e6 + 50e6 * column) == (0.0, pytest.approx(551e6))


def made(folder, duration="2 s", **asked):
    places = {"out": folder, "store": {"signals": "none"}, "engine": "in-process"}
    return package.sweep(name=folder.name, duration=duration, **places, **asked)


def test_of_more_than_two_parameters_the_two_that_matter_most_are_shown(tmp_path):
    grid = {"K_i": [0, 1e-8], "wavelet.name": ["db8", "db4"], "P_s": ["10 MPa", "21 MPa"]}
    three = made(tmp_path / "three", grid=grid)
    plane = three.composed.plane
    assert plane.shape == (2, 2)
    assert plane.headers[0].startswith("K_i")
    assert len(plane.others) == 1
    inside = plane.cell >= 0
    assert np.bincount(plane.cell[inside]).tolist() == [2, 2, 2, 2]
    assert three.grid().delta.dims == ("K_i", "swept_wavelet_name", "P_s", "level")


def test_a_baseline_is_marked_only_if_all_runs_have_it_and_one_axis_is_a_grid_that_drawn_points_are_not(
    tmp_path,
):
    own = made(tmp_path / "own", grid={"K_i": [0, 1e-8], "P_s": ["10 MPa", "21 MPa"]})
    assert own.composed.plane.baseline is None
    one = made(tmp_path / "one", grid={"K_i": [1e-8, 0]})
    assert one.grid().delta.dims == ("K_i", "level")
    assert one.grid().K_i.values.tolist() == [0.0, 1e-8]
    assert [run.parameters["K_i"] for run in one[:2]] == [1e-8, 0.0]
    over = {"EBM": {"uniform": "±20 %"}, "m": {"uniform": "±10 %"}}
    drawn = made(tmp_path / "drawn", "1 s", sample={"count": 32, "over": over})
    assert drawn.composed.plane is None
    assert "sensitivity" not in drawn.composed.figures()
    with pytest.raises(ReportError):
        drawn.grid()
    assert {"EBM", "m"} <= set(drawn.dataset.coords)


def test_the_file_alone_is_a_cube_and_the_extra_baseline_does_not_stand_in_the_way(results):
    assert len(results) == 82
    with xarray.open_dataset(results.file, engine="h5netcdf") as stored:
        whole = stored.set_index(run=["EBM", "K_i"]).unstack("run")
        cube = stored.isel(run=stored.swept).set_index(run=["EBM", "K_i"]).unstack("run")
    assert (whole.sizes["EBM"], whole.sizes["K_i"]) == (10, 9)
    np.testing.assert_array_equal(whole.detail_rms.sel(EBM=cube.EBM), cube.detail_rms)
    assert (cube.sizes["EBM"], cube.sizes["K_i"]) == (9, 9)
    assert cube.EBM.values.tolist() == np.linspace(500e6, 900e6, 9).tolist()
    assert np.isfinite(cube.detail_rms).all()


def test_a_file_without_coordinates_says_how_to_get_them(results, tmp_path):
    shutil.copytree(results.folder, tmp_path / "old")
    old = package.load(tmp_path / "old")
    with h5py.File(old.file, "r+") as file:
        del file.attrs["coordinates"], file["EBM"], file["K_i"], file["swept"]
    with pytest.raises(ReportError, match="collect"):
        old.grid()
    np.testing.assert_array_equal(package.collect(old.folder).grid().delta, results.grid().delta)


def test_a_stored_run_is_the_run_that_was_simulated(results):
    asked = {name: results[10].parameters[name] for name in ("EBM", "K_i")}
    again = package.simulate(duration="4 s", **asked)
    assert (results[10].run_id, results[10].parameters) == (again.run_id, again.parameters)
    np.testing.assert_array_equal(results.signals(10)["P1"], again.P1)
    np.testing.assert_array_equal(results[10].detail_rms, again.detail_rms)


def test_a_run_draws_chosen_channels_from_an_instant_on_and_says_if_none_are_stored(results, tmp_path):
    figure = results[3].plot(channels=["P1", "x"], start=3.0)
    assert len(figure.axes) == 2
    assert min(line.get_xdata().min() for axis in figure.axes for line in axis.lines) == 3.0
    with pytest.raises(UnknownNameError):
        results[3].plot("P9")
    bare = made(tmp_path / "bare", grid={"EBM": [6e8, 7e8]})
    assert bare.signals(0) == {}
    with pytest.raises(ReportError):
        bare[0].plot()


def test_the_wide_form_has_a_line_for_each_run(folder):
    wide = run("report", "results/mine", "--format", "wide", cwd=folder).stdout
    lines, rows = [*csv.DictReader(wide.splitlines())], run_json("report", "results/mine", cwd=folder)["rows"]
    assert len(lines) == len(rows) == 82
    for line, row in zip(lines, rows, strict=True):
        assert float(line["bulk_modulus_MPa"]) == row["bulk_modulus_MPa"]
        assert [float(line[f"delta_d{k}_percent"]) for k in range(1, 6)] == row["delta_fixed_percent"]


def test_coordinates_have_short_names_that_no_variable_has():
    names = ("fluid.bulk_modulus", "friction.coulomb", "actuator.stroke", "friction.law", "wavelet.phase")
    short = ["EBM", "F_c", "stroke", "swept_friction_law", "swept_wavelet_phase"]
    assert [coordinate(name) for name in names] == short
