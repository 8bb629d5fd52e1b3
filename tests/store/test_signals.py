"""Signals on their way from shards into the experiment file."""

import h5py
import numpy as np
import pytest

from hydrofdi.api.sweep import collect
from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.run_table.runs import run_identity
from hydrofdi.execution import Batch, Job, compute_columns
from hydrofdi.execution.compute import compute_shard
from hydrofdi.store.reading import write_request

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
