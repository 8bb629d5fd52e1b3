"""Stored signals measured again: what needs no simulation, and that the bits are those of one."""

import json
import shutil

import h5py
import numpy as np
import pytest

from hydrofdi.api.folders import verify, why
from hydrofdi.api.plan import plan_sweep
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.execution import InProcessEngine
from hydrofdi.store.index import read_index

NOISY = """\
name: noisy
record: {duration: 4 s}
input: {period: 1 s}
pressure_1_sensor: {noise: 1 kPa}
store: {signals: STORED}
sweep:
  grid:
    leakage.internal_flow: [0.5 L/min]
    fluid.bulk_modulus: [551 MPa, 827 MPa]
"""
OTHER = [
    "wavelet={name: db4, levels: 4, phase: all}",
    "analysis.discard=1 period",
    "indicators={dwt: {}, coarse: {kind: dwt, levels: 2}}",
]


def noisy(folder, signals="all", *settings):
    config = folder / "noisy.yaml"
    config.write_text(NOISY.replace("STORED", signals))
    return load_experiment(config, settings)


def swept(experiment, directory):
    return run_sweep(experiment, directory, InProcessEngine())


def contents(file):
    with h5py.File(file) as data:
        return {name: data[name][()] for name in data}


def assert_same_bits(one, other):
    assert one.keys() == other.keys()
    for name, values in one.items():
        is_float = values.dtype.kind == "f"
        assert np.array_equal(values, other[name], equal_nan=is_float), name


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A folder with the records of the default analysis."""
    folder = tmp_path_factory.mktemp("first")
    swept(noisy(folder), folder / "noisy")
    return folder


def copied(first, tmp_path):
    shutil.copytree(first / "noisy", tmp_path / "noisy")
    return tmp_path / "noisy"


def test_another_analysis_simulates_nothing_and_gives_the_bits_of_a_simulation(first, tmp_path):
    directory = copied(first, tmp_path)
    other = noisy(tmp_path, "all", *OTHER)
    plan = plan_sweep(other, directory)
    assert (len(plan.missing), plan.n_simulated, len(plan.measurable)) == (4, 0, 4)
    assert plan.reasons() == {"another analysis of a stored record, measured from its stored signals": 4}
    summary = swept(other, directory)
    assert (summary.completed, summary.measured, summary.failed) == (4, 4, 0)
    swept(other, tmp_path / "anew")
    assert_same_bits(contents(directory / "noisy.h5"), contents(tmp_path / "anew" / "noisy.h5"))
    assert verify(directory)


def test_what_was_measured_before_is_stored_still(first, tmp_path):
    directory = copied(first, tmp_path)
    swept(noisy(tmp_path, "all", *OTHER), directory)
    back = swept(noisy(tmp_path), directory)
    assert (back.completed, back.skipped) == (0, 4)
    assert_same_bits(contents(directory / "noisy.h5"), contents(first / "noisy" / "noisy.h5"))


def test_why_tells_what_is_not_stored(first, tmp_path):
    directory = copied(first, tmp_path)
    (directory / "experiment.json").write_text(noisy(tmp_path, "all", *OTHER).model_dump_json())
    again = why(directory, "0")
    assert again.reason == "another analysis of a stored record, measured from its stored signals"
    assert again.record_id != again.run_id
    other_plant = noisy(tmp_path, "all", "friction.viscous=60")
    (directory / "experiment.json").write_text(other_plant.model_dump_json())
    assert why(directory, "0").reason == "new"


@pytest.mark.parametrize(
    ("signals", "settings", "reason"),
    [
        ("none", [], "no stored signals of chamber_1_pressure"),
        (
            "pressures",
            ["indicators={dwt: {}, speed: {kind: dwt, channel: piston_velocity}}"],
            "no stored signals of piston_velocity",
        ),
        ("pressures, dtype: float32", [], "stored signals in single precision"),
    ],
)
def test_where_signals_are_not_stored_the_plan_says_why_it_simulates(tmp_path, signals, settings, reason):
    swept(noisy(tmp_path, signals), tmp_path / "noisy")
    other = noisy(tmp_path, signals, "wavelet.levels=4", *settings)
    plan = plan_sweep(other, tmp_path / "noisy")
    assert plan.n_simulated == 4
    ((because, count),) = plan.reasons().items()
    assert count == 4
    assert reason in because
    assert swept(other, tmp_path / "noisy").measured == 0


def test_runs_that_differ_in_their_analysis_share_their_records(tmp_path):
    analyses = ("sweep.grid.wavelet.levels=[3, 4]", "sweep.grid.analysis.discard=[0 s, 1 s]")
    experiment = noisy(tmp_path, "none", *analyses)
    plan = plan_sweep(experiment, tmp_path / "noisy")
    assert len(plan.missing) == 4 * plan.n_simulated == 16
    swept(experiment, tmp_path / "noisy")
    index = read_index(tmp_path / "noisy")
    assert (len(index.runs), len(index.records)) == (16, 4)


def test_a_record_that_failed_is_not_simulated_again(tmp_path):
    settings = ("sweep.grid.fluid.bulk_modulus=[551 MPa, 1e7 MPa]",)
    assert swept(noisy(tmp_path, "pressures", *settings), tmp_path / "noisy").failed > 0
    other = noisy(tmp_path, "pressures", *settings, "wavelet.levels=4")
    assert plan_sweep(other, tmp_path / "noisy").n_simulated == 0
    summary = swept(other, tmp_path / "noisy")
    assert summary.measured == summary.planned
    rows = contents(summary.file)
    failed = rows["status"] != b"ok"
    assert failed.any()
    assert np.isnan(rows["dwt.d1"][failed]).all()
    assert np.isfinite(rows["dwt.d1"][~failed]).all()


def test_workers_measure_stored_signals_as_well(first, tmp_path, hydrofdi):
    copied(first, tmp_path)
    config = tmp_path / "noisy.yaml"
    config.write_text(NOISY.replace("STORED", "all"))
    result = hydrofdi(
        "sweep", config, "--out", "noisy", "--set", "wavelet.levels=3", "--workers", "2", "--json"
    )
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["measured"] == 4
