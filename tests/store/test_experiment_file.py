"""The experiment file: what it holds, its units and signals."""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import collect
from hydrofdi.config import ExperimentConfig, expand_runs, load_experiment
from hydrofdi.config.run_table.runs import run_identity
from hydrofdi.execution import Batch, Job, compute_columns
from hydrofdi.execution.compute import compute_shard
from hydrofdi.store.reading import write_request
from hydrofdi.store.records import StoredRecords
from hydrofdi.transforms.wavelet import detail_rms
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


@pytest.fixture
def dataset(small_sweep):
    with xarray.open_dataset(small_sweep.file, engine="h5netcdf") as opened:
        yield opened


def test_xarray_opens_it_as_a_labelled_data_set(dataset):
    assert dict(dataset.sizes) == {"run": 4, "time": 1000, "level": 5}
    for name in SIGNALS.keys() - {"input_voltage"}:
        assert dataset[name].dims == ("run", "time")
    assert dataset["input_voltage"].dims in {("run", "time"), ("time",)}
    assert dataset["detail_rms"].dims == ("run", "level")
    for name in PER_RUN:
        assert dataset[name].dims == ("run",)
    np.testing.assert_allclose(dataset["time"], np.arange(1000) / 500.0)
    np.testing.assert_array_equal(dataset["level"], [1, 2, 3, 4, 5])


def test_every_variable_says_its_unit_and_its_long_name(small_sweep):
    with h5py.File(small_sweep.file) as file:
        for name, variable in file.items():
            assert isinstance(variable.attrs["units"], str), name
            assert variable.attrs["long_name"], name
        found = {name: file[name].attrs["units"] for name in {**SIGNALS, **PER_RUN}}
        assert found == {**SIGNALS, **PER_RUN}
        assert file["detail_rms"].attrs["units"] == "Pa"


def test_it_says_what_it_was_made_from(small_sweep):
    with h5py.File(small_sweep.file) as file:
        attributes = dict(file.attrs)
    stored = ExperimentConfig.model_validate_json(attributes["configuration"])
    assert stored == load_experiment(small_sweep.config)
    assert attributes["format_version"] >= 1
    for library in ("hydrofdi", "python", "numpy", "numba", "h5py", "pywavelets"):
        assert attributes[f"version_{library}"]


def test_its_numbers_are_those_of_the_runs_it_names(dataset, small_sweep):
    np.testing.assert_array_equal(dataset["bulk_modulus"], [551e6, 827e6, 551e6, 827e6])
    np.testing.assert_array_equal(dataset["internal_leakage_coefficient"], [0.0, 0.0, 1e-8, 1e-8])
    assert [str(status) for status in dataset["status"].values] == ["ok"] * 4
    assert len(set(dataset["run_id"].values)) == 4


def test_the_features_are_those_of_the_stored_signals(dataset):
    wavelet = load_experiment().wavelet
    np.testing.assert_array_equal(
        dataset["detail_rms"], detail_rms(dataset["chamber_1_pressure"].values, wavelet)
    )
    flow = np.abs(dataset["internal_leakage_flow"]).mean("time")
    np.testing.assert_allclose(dataset["mean_internal_leakage_flow"], flow, rtol=1e-12)


@pytest.mark.parametrize(
    ("signals", "kept"), [("all", set(SIGNALS)), ("pressures", PRESSURES), ("none", set())]
)
def test_the_signals_that_are_asked_for_are_kept(hydrofdi, small_sweep, tmp_path, signals, kept):
    shutil.copytree(small_sweep.folder, tmp_path, dirs_exist_ok=True)
    config = tmp_path / "experiment.yaml"
    result = hydrofdi(
        "sweep", config, "--json", "--engine", "in-process", "--set", f"store.signals={signals}"
    )
    assert json.loads(result.stdout)["completed"] == 0
    with h5py.File(tmp_path / "results/small/small.h5") as file:
        assert SIGNALS.keys() & file.keys() == kept
        assert ("time" in file) == bool(kept)
        assert file["detail_rms"].shape == (4, 5)


def test_signals_that_were_not_kept_are_computed_when_they_are_asked_for(hydrofdi, tmp_path, small_sweep):
    config = small_sweep.config
    for signals, workers, completed in [("none", 1, 4), ("all", 3, 4), ("pressures", 1, 0), ("all", 1, 0)]:
        arguments = ["--workers", str(workers), "--set", f"store.signals={signals}", "--json"]
        result = hydrofdi("sweep", config, *arguments)
        assert result.returncode == 0, result.stderr
        assert json.loads(result.stdout)["completed"] == completed
    with h5py.File(tmp_path / "results/small/small.h5") as file, h5py.File(small_sweep.file) as whole:
        for name in SIGNALS:
            np.testing.assert_array_equal(file[name], whole[name])


UNSET = """\
name: unset
input: {period: 0.5 s}
record: {duration: 2 s}
store: {signals: none}
sweep:
  zip:
    valve.largest_speed: [null, 10 mm/s]
    pressure_1_sensor.bandwidth: [null, 100 Hz]
    pressure_1_sensor.order: [ideal, first]
    analysis.discard: [0.5 s, 1 period]
"""


def test_a_number_that_is_not_set_is_nan_and_texts_have_no_unit(tmp_path):
    with h5py.File(sweep_in(tmp_path, UNSET).file) as file:
        for name, values, units in (
            ("valve_largest_speed", [np.nan, 0.01], "m/s"),
            ("pressure_1_sensor_bandwidth", [np.nan, 100.0], "Hz"),
        ):
            np.testing.assert_array_equal(file[name][:], values)
            assert file[name].attrs["units"] == units
        assert list(file["analysis_discard"].asstr()[:]) == ["0.5 s", "1 period"]
        assert list(file["pressure_1_sensor_order"].asstr()[:]) == ["ideal", "first"]
        assert file["analysis_discard"].attrs["units"] == ""


MEASURED = """\
name: flows
record: {duration: 6 s}
store: {signals: none}
indicators: {dwt: {}, flow_balance: {}}
leakage: {internal_coefficient: 1e-8}
"""


def test_all_units_of_a_file_have_one_style(tmp_path):
    sweep = sweep_in(tmp_path, MEASURED)
    (path,) = sweep.directory.glob("*.h5")
    with h5py.File(path) as file:
        units = {name: str(variable.attrs.get("units", "")) for name, variable in file.items()}
    assert units["flow_balance.leakage"] == "m3 s-1"
    assert not [name for name, unit in units.items() if set("/^") & set(unit)]


_ANALYSES = """\
name: analyses
record: {duration: 2 s}
store: {signals: pressures}
analysis: {discard: 1 s}
sweep:
  grid:
    analysis.discard: [0 s, 1 s]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


def test_records_have_the_identity_of_the_file_and_come_once(tmp_path: Path) -> None:
    swept = sweep_in(tmp_path, _ANALYSES)
    columns = read_results(swept.file).columns
    named = list(dict.fromkeys(columns["record_id"].astype(str)))
    assert len(columns["run_id"]) == 4
    assert len(named) == 2
    sources = [
        StoredRecords(read_results(swept.file), "file"),
        StoredRecords(read_results(swept.directory), "folder"),
        SimulatedRecords(load_experiment(swept.config), "simulated"),
    ]
    for source in sources:
        batches = list(source.batches(labels=True))
        assert [record for batch in batches for record in batch.record_ids] == named
        assert [label for batch in batches for label in batch.labels or ()] == [
            "sealed, 551 MPa",
            "sealed, 689 MPa",
        ]


EXPERIMENT = """\
name: rows
record: {duration: 2 s}
sweep:
  zip:
    fluid.bulk_modulus: [551 MPa, 600 MPa, 650 MPa, 700 MPa, 750 MPa, 827 MPa]
    load.random_force: [0 N, 0 N, 400 N, 0 N, 500 N, 0 N]
"""


def experiment_with(file, **store):
    return load_experiment(file(EXPERIMENT), [f"store.{key}={value}" for key, value in store.items()])


def jobs_of(experiment):
    runs = expand_runs(experiment).runs
    return [Job(run_identity(run), run.parameters, 0.0) for run in runs]


def collected(folder, experiment, batches):
    """The experiment file from shards with these rows; each batch may be stored in its own way."""
    jobs = jobs_of(experiment)
    write_request(folder, experiment)
    for rows, store in batches:
        compute_shard(Batch(tuple(jobs[row] for row in rows), folder, store))
    return collect(folder).file


@pytest.mark.parametrize("compression", ["none", "lzf", "gzip"])
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_rows_from_any_shards_are_those_of_the_runs_and_the_file_has_the_same_bytes(
    experiment_file, tmp_path, compression, dtype
):
    experiment = experiment_with(experiment_file, compression=compression, dtype=dtype)
    n_run = len(jobs_of(experiment))
    together = [range(n_run)]
    apart = [range(0, n_run, 2), range(n_run - 1 - n_run % 2, 0, -2)]
    files = [
        collected(tmp_path / str(number), experiment, [(rows, experiment.store) for rows in split])
        for number, split in enumerate([together, apart])
    ]
    columns = compute_columns(jobs_of(experiment))
    with h5py.File(files[1]) as file:
        for name in ("chamber_1_pressure", "load_force", "internal_leakage_flow", "reference_position"):
            np.testing.assert_array_equal(file[name], columns[name].astype(dtype))
    if compression != "lzf":  # whose bytes depend on what the process compressed before
        assert files[0].read_bytes() == files[1].read_bytes()


def test_shards_of_another_precision_or_compression_fit_into_one_file(experiment_file, tmp_path):
    experiment = experiment_with(experiment_file, dtype="float32")
    stores = [
        experiment_with(experiment_file, compression=compression).store for compression in ("none", "gzip")
    ]
    n_run = len(jobs_of(experiment))
    file = collected(tmp_path, experiment, [(range(3), stores[0]), (range(3, n_run), stores[1])])
    columns = compute_columns(jobs_of(experiment))
    with h5py.File(file) as opened:
        for name in ("chamber_1_pressure", "load_force"):
            np.testing.assert_array_equal(opened[name], columns[name].astype("float32"))


def test_runs_that_are_stored_without_the_signals_have_holes_in_them(experiment_file, tmp_path):
    experiment = experiment_with(experiment_file)
    few = experiment_with(experiment_file, signals="pressures").store
    n_run = len(jobs_of(experiment))
    file = collected(tmp_path, experiment, [(range(2, n_run), experiment.store), (range(1), few)])
    columns = compute_columns(jobs_of(experiment))
    with h5py.File(file) as opened:
        assert list(opened["status"].asstr()[:3]) == ["ok", "missing", "ok"]
        pressure, position = opened["chamber_1_pressure"][:], opened["piston_position"][:]
    has_pressure = np.isfinite(pressure).all(axis=1)
    has_position = np.isfinite(position).all(axis=1)
    assert list(has_pressure) == [True, False] + [True] * (n_run - 2)
    assert list(has_position) == [False, False] + [True] * (n_run - 2)
    np.testing.assert_array_equal(pressure[has_pressure], columns["chamber_1_pressure"][has_pressure])
    assert np.isnan(pressure[1]).all()
