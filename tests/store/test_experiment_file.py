import json
import shutil

import h5py
import numpy as np
import pytest
import xarray

from hydrofdi.config import ExperimentConfig, load_experiment
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
