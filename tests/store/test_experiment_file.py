"""The experiment file: what it holds, its units and signals."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.api.sweeps import collect
from hydrofdi.config import ExperimentConfig, expand_runs, load_experiment
from hydrofdi.config.experiment import StoreConfig
from hydrofdi.config.runs import run_identity
from hydrofdi.execution.compute import Batch, Job, compute_columns, compute_shard
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.store import names
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.folder import write_request
from hydrofdi.store.results import read_results
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


@pytest.fixture
def dataset(small_sweep):
    with xarray.open_dataset(small_sweep.file, engine="h5netcdf") as opened:
        yield opened


def test_xarray_opens_it_as_a_labelled_data_set_with_the_numbers_of_its_runs(dataset):
    assert dict(dataset.sizes) == {"run": 4, "time": 1000, "level": 5}
    for name in SIGNALS.keys() - {"input_voltage"}:
        assert dataset[name].dims == ("run", "time")
    assert dataset["input_voltage"].dims == ("time",)
    assert dataset["detail_rms"].dims == ("run", "level")
    for name in PER_RUN:
        assert dataset[name].dims == ("run",)
    np.testing.assert_allclose(dataset["time"], np.arange(1000) / 500.0)
    np.testing.assert_array_equal(dataset["level"], [1, 2, 3, 4, 5])
    np.testing.assert_array_equal(dataset["bulk_modulus"], [551e6, 827e6, 551e6, 827e6])
    np.testing.assert_array_equal(dataset["internal_leakage_coefficient"], [0.0, 0.0, 1e-8, 1e-8])
    assert [str(status) for status in dataset["status"].values] == ["ok"] * 4
    assert len(set(dataset["run_id"].values)) == 4


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


def test_the_features_are_those_of_the_stored_signals(dataset):
    wavelet = load_experiment().wavelet
    np.testing.assert_array_equal(
        dataset["detail_rms"], detail_rms(dataset["chamber_1_pressure"].values, wavelet)
    )
    flow = np.abs(dataset["internal_leakage_flow"]).mean("time")
    np.testing.assert_allclose(dataset["mean_internal_leakage_flow"], flow, rtol=1e-12)


@pytest.mark.parametrize(
    ("signals", "kept"),
    [
        ("all", set(SIGNALS)),
        ("pressures", PRESSURES),
        ("none", set()),
        ("[spool_position, chamber_1_pressure]", {"spool_position", "chamber_1_pressure"}),
    ],
)
def test_the_signals_that_are_asked_for_are_kept_and_not_computed_again(small_sweep, tmp_path, signals, kept):
    shutil.copytree(small_sweep.directory, tmp_path / "small")
    sweep = ("sweep", small_sweep.config, "--out", tmp_path / "small", "--engine", "in-process")
    assert run_json(*sweep, "--set", f"store.signals={signals}")["completed"] == 0
    with h5py.File(tmp_path / "small" / "small.h5") as file:
        assert SIGNALS.keys() & file.keys() == kept
        assert ("time" in file) == bool(kept)
        assert file["detail_rms"].shape == (4, 5)


def test_signals_that_were_not_kept_are_computed_when_they_are_asked_for(tmp_path, small_sweep):
    sweep = ("sweep", small_sweep.config, "--out", tmp_path / "small", "--engine", "in-process")
    spool, position = ("[chamber_1_pressure, spool_position]", "[spool_position, piston_position]")
    for signals, completed in [(spool, 4), (position, 4), ("all", 4), ("pressures", 0), ("all", 0)]:
        assert run_json(*sweep, "--set", f"store.signals={signals}")["completed"] == completed
    with h5py.File(tmp_path / "small" / "small.h5") as file, h5py.File(small_sweep.file) as whole:
        for name in SIGNALS:
            np.testing.assert_array_equal(file[name], whole[name])


@pytest.mark.parametrize(
    ("given", "text"),
    [
        (["spool_position", "chamber_1_pressure"], "spool_position,chamber_1_pressure"),
        (["chamber_1_pressure", "spool_position"], "spool_position,chamber_1_pressure"),
        (["chamber_2_pressure", "chamber_1_pressure"], "pressures"),
        ([], "none"),
        (list(names.SIGNALS), "all"),
    ],
)
def test_a_choice_of_signals_has_one_text_and_is_read_back(given, text):
    store = StoreConfig(signals=given)
    assert store.signals == text
    assert StoreConfig.model_validate_json(store.model_dump_json()) == store


UNSET = """\
name: unset
input: {period: 0.5 s}
record: {duration: 2 s}
store: {signals: none}
sweep:
  zip:
    actuator.stroke: [null, 400 mm]
    pressure_1_sensor.bandwidth: [null, 100 Hz]
    pressure_1_sensor.order: [ideal, first]
    analysis.discard: [0.5 s, 1 period]
"""


def test_a_number_that_is_not_set_is_nan_and_texts_have_no_unit(tmp_path):
    with h5py.File(sweep_in(tmp_path, UNSET).file) as file:
        for name, values, units in (
            ("actuator_stroke", [np.nan, 0.4], "m"),
            ("pressure_1_sensor_bandwidth", [np.nan, 100.0], "Hz"),
        ):
            np.testing.assert_array_equal(file[name][:], values)
            assert file[name].attrs["units"] == units
        assert list(file["analysis_discard"].asstr()[:]) == ["0.5 s", "1 period"]
        assert list(file["pressure_1_sensor_order"].asstr()[:]) == ["ideal", "first"]
        assert file["analysis_discard"].attrs["units"] == ""


def test_units_of_indicators_have_the_style_of_the_others(tmp_path):
    indicators = "record: {duration: 6 s}\nstore: {signals: none}\nindicators: {dwt: {}, flow_balance: {}}\n"
    with h5py.File(sweep_in(tmp_path, f"name: flows\n{indicators}").file) as file:
        units = {name: variable.attrs["units"] for name, variable in file.items()}
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


@pytest.fixture(scope="module")
def columns(tmp_path_factory):
    """What is stored of all runs, simulated at once."""
    file = tmp_path_factory.mktemp("rows") / "rows.yaml"
    file.write_text(EXPERIMENT)
    return compute_columns(jobs_of(load_experiment(file)))


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


@pytest.mark.parametrize(
    ("dtype", "compression"),
    [("float64", "none"), ("float32", "none"), ("float64", "lzf"), ("float64", "gzip")],
)
def test_rows_from_any_shards_are_those_of_the_runs_and_the_file_has_the_same_bytes(
    experiment_file, tmp_path, columns, compression, dtype
):
    experiment = experiment_with(experiment_file, compression=compression, dtype=dtype)
    together, apart = [range(8)], [range(0, 8, 2), range(7, 0, -2)]
    files = [
        collected(tmp_path / str(number), experiment, [(rows, experiment.store) for rows in split])
        for number, split in enumerate([together, apart])
    ]
    with h5py.File(files[1]) as file:
        for name in ("chamber_1_pressure", "load_force", "internal_leakage_flow", "reference_position"):
            np.testing.assert_array_equal(file[name], columns[name].astype(dtype))
    if compression != "lzf":  # whose bytes depend on what the process compressed before
        assert files[0].read_bytes() == files[1].read_bytes()


def test_shards_of_another_precision_or_compression_fit_into_one_file(experiment_file, tmp_path, columns):
    experiment = experiment_with(experiment_file, dtype="float32")
    plain, packed = (
        experiment_with(experiment_file, compression=compression).store for compression in ("none", "gzip")
    )
    file = collected(tmp_path, experiment, [(range(3), plain), (range(3, 8), packed)])
    with h5py.File(file) as opened:
        for name in ("chamber_1_pressure", "load_force"):
            np.testing.assert_array_equal(opened[name], columns[name].astype("float32"))


def test_runs_that_are_stored_without_the_signals_have_holes_in_them(experiment_file, tmp_path, columns):
    experiment = experiment_with(experiment_file)
    few = experiment_with(experiment_file, signals="pressures").store
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
