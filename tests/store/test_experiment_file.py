"""The experiment file: what it holds, its units and signals."""

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.sweeps import collect
from hydrofdi.config import ExperimentConfig, expand_runs, load_experiment
from hydrofdi.config.runs import run_identity
from hydrofdi.execution.compute import Batch, Job, compute_columns, compute_shard
from hydrofdi.store.folder import write_request
from hydrofdi.transforms import detail_rms
from tests.commands import run_json
from tests.conftest import sweep_in

SIGNALS = {
    "piston_position": "m", "piston_velocity": "m s-1", "spool_position": "m", "chamber_1_pressure": "Pa",
    "chamber_2_pressure": "Pa", "internal_leakage_flow": "m3 s-1", "input_voltage": "V",
}  # fmt: skip
PER_RUN = {
    "mean_internal_leakage_flow": "m3 s-1", "bulk_modulus": "Pa",
    "internal_leakage_coefficient": "m3.5 kg-0.5", "run_id": "", "status": "",
}  # fmt: skip
PRESSURES = {"chamber_1_pressure", "chamber_2_pressure"}


def test_xarray_opens_it_as_a_labelled_data_set_with_the_numbers_of_its_runs(small_sweep):
    with xarray.open_dataset(small_sweep.file, engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == {"run": 4, "time": 1000, "level": 5}
        for group, dims in (
            (SIGNALS.keys() - {"input_voltage"}, ("run", "time")), ({"input_voltage"}, ("time",)),
            ({"detail_rms"}, ("run", "level")), (PER_RUN, ("run",)),
        ):  # fmt: skip
            assert {dataset[name].dims for name in group} == {dims}
        np.testing.assert_allclose(dataset["time"], np.arange(1000) / 500.0)
        np.testing.assert_array_equal(dataset["level"], [1, 2, 3, 4, 5])
        np.testing.assert_array_equal(dataset["bulk_modulus"], [551e6, 827e6, 551e6, 827e6])
        np.testing.assert_array_equal(dataset["internal_leakage_coefficient"], [0.0, 0.0, 1e-8, 1e-8])
        assert [str(status) for status in dataset["status"].values] == ["ok"] * 4
        features = detail_rms(dataset["chamber_1_pressure"].values, load_experiment().wavelet)
        np.testing.assert_array_equal(dataset["detail_rms"], features)
        flow = np.abs(dataset["internal_leakage_flow"]).mean("time")
        np.testing.assert_allclose(dataset["mean_internal_leakage_flow"], flow, rtol=1e-12)


def test_it_says_its_units_and_what_it_was_made_from(small_sweep):
    with h5py.File(small_sweep.file) as file:
        units = {name: variable.attrs["units"] for name, variable in file.items()}
        assert all(variable.attrs["long_name"] for variable in file.values())
        axes = [dim for variable in file.values() if not variable.is_scale for dim in variable.dims]
        assert {len(axis) for axis in axes} == {1}, "each has its coordinate"
        attributes = dict(file.attrs)
    assert units.items() >= {**SIGNALS, **PER_RUN, "detail_rms": "Pa"}.items()
    stored = ExperimentConfig.model_validate_json(attributes["configuration"])
    assert stored == load_experiment(small_sweep.config)
    for library in ("hydrofdi", "python", "numpy", "numba", "h5py", "pywavelets"):
        assert attributes[f"version_{library}"]


def test_only_signals_that_were_not_kept_are_computed_when_they_are_asked_for(tmp_path, small_sweep):
    sweep = ("sweep", small_sweep.config, "--out", tmp_path / "small", "--engine", "in-process")
    for signals, kept, completed in (
        ("[chamber_1_pressure, spool_position]", {"chamber_1_pressure", "spool_position"}, 4),
        ("[spool_position, piston_position]", {"spool_position", "piston_position"}, 4),
        ("all", set(SIGNALS), 4), ("pressures", PRESSURES, 0), ("none", set(), 0), ("all", set(SIGNALS), 0),
    ):  # fmt: skip
        assert run_json(*sweep, "--set", f"store.signals={signals}")["completed"] == completed
        with h5py.File(tmp_path / "small" / "small.h5") as file, h5py.File(small_sweep.file) as whole:
            assert SIGNALS.keys() & file.keys() == kept
            assert ("time" in file) == bool(kept)
            for name in ("detail_rms", *kept):
                np.testing.assert_array_equal(file[name], whole[name])


UNSET = """\
name: unset
input: {period: 0.5 s}
record: {duration: 2 s}
store: {signals: none}
indicators: {dwt: {}, flow_balance: {}}
sweep:
  zip:
    actuator.stroke: [null, 400 mm]
    analysis.discard: [0.5 s, 1 period]
"""


def test_a_number_that_is_not_set_is_nan_texts_have_no_unit_and_units_one_style(tmp_path):
    with h5py.File(sweep_in(tmp_path, UNSET).file) as file:
        np.testing.assert_array_equal(file["actuator_stroke"][:], [np.nan, 0.4])
        assert list(file["analysis_discard"].asstr()[:]) == ["0.5 s", "1 period"]
        units = {name: variable.attrs["units"] for name, variable in file.items()}
    expected = {"actuator_stroke": "m", "analysis_discard": "", "flow_balance.leakage": "m3 s-1"}
    assert units.items() >= expected.items()
    assert not [name for name, unit in units.items() if set("/^") & set(unit)]


EXPERIMENT = {
    "name": "rows",
    "record": {"duration": "2 s"},
    "sweep": {
        "zip": {
            "fluid.bulk_modulus": ["551 MPa", "600 MPa", "650 MPa", "700 MPa", "750 MPa", "827 MPa"],
            "load.random_force": ["0 N", "0 N", "400 N", "0 N", "500 N", "0 N"],
        }
    },
}


def experiment_with(**store):
    return load_experiment(EXPERIMENT, [f"store.{key}={value}" for key, value in store.items()])


def jobs_of(experiment):
    return [Job(run_identity(run), run.parameters, 0.0) for run in expand_runs(experiment).runs]


@pytest.fixture(scope="module")
def columns():
    """What is stored of all runs, simulated at once."""
    return compute_columns(jobs_of(experiment_with()))


def collected(folder, experiment, batches):
    """The experiment file from shards with these rows; each batch may be stored in its own way."""
    jobs = jobs_of(experiment)
    write_request(folder, experiment)
    for rows, store in batches:
        compute_shard(Batch(tuple(jobs[row] for row in rows), folder, store))
    return collect(folder).file


@pytest.mark.parametrize(("dtype", "compression", "other"), [
    ("float64", "none", "none"), ("float32", "none", "none"), ("float64", "lzf", "lzf"),
    ("float64", "gzip", "gzip"), ("float32", "none", "gzip"),
])  # fmt: skip
def test_rows_from_any_shards_are_those_of_the_runs_and_the_file_has_the_same_bytes(
    tmp_path, columns, dtype, compression, other
):
    experiment = experiment_with(compression=compression, dtype=dtype)
    store, apart = experiment.store, experiment_with(compression=other, dtype=dtype).store
    file = collected(tmp_path / "1", experiment, [(range(0, 8, 2), store), (range(7, 0, -2), apart)])
    with h5py.File(file) as opened:
        for name in ("chamber_1_pressure", "load_force", "internal_leakage_flow", "reference_position"):
            np.testing.assert_array_equal(opened[name], columns[name].astype(dtype))
    if compression == other != "lzf":  # whose bytes depend on what the process compressed before
        assert collected(tmp_path / "0", experiment, [(range(8), store)]).read_bytes() == file.read_bytes()


def test_runs_that_are_stored_without_the_signals_have_holes_in_them(tmp_path, columns):
    experiment, few = experiment_with(), experiment_with(signals="pressures").store
    file = collected(tmp_path, experiment, [(range(2, 8), experiment.store), (range(1), few)])
    with h5py.File(file) as opened:
        assert list(opened["status"].asstr()[:3]) == ["ok", "missing", "ok"]
        pressure, position = opened["chamber_1_pressure"][:], opened["piston_position"][:]
    has_pressure = np.isfinite(pressure).all(axis=1)
    has_position = np.isfinite(position).all(axis=1)
    assert list(has_pressure) == [True, False] + [True] * 6
    assert list(has_position) == [False, False] + [True] * 6
    np.testing.assert_array_equal(pressure[has_pressure], columns["chamber_1_pressure"][has_pressure])
    assert np.isnan(pressure[1]).all()
