"""The real command with sensors: the same bits however it is run."""

import json

import h5py
import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.report.runs import run_table
from tests.commands import run_hydrofdi
from tests.conftest import REPOSITORY, sweep_in, swept

SWEEP = """\
name: measured
record: {duration: 2 s}
pressure_1_sensor: {order: first, bandwidth: 150 Hz, noise: 5 kPa, lowest: 0, highest: 250 bar, bits: 12}
measurement: {jitter: 20 µs}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-8]
    measurement.seed: [0, 1]
"""


def signals_of(swept):
    """Everything that is stored with a run, by identity."""
    with h5py.File(swept.file) as file:
        run_ids = list(file["run_id"].asstr()[:])
        names = ("detail_rms", "chamber_1_pressure", "chamber_2_pressure", "piston_velocity", "input_voltage")
        return {name: dict(zip(run_ids, file[name][:], strict=True)) for name in names}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("one"), SWEEP)


def test_sweep_has_the_same_bits_in_other_order_with_more_workers(measured, tmp_path):
    turned = SWEEP.replace("[0, 1e-8]", "[1e-8, 2e-9, 0]").replace("seed: [0, 1]", "seed: [1, 0]")
    other = signals_of(sweep_in(tmp_path, turned, "--engine", "local", "--workers", "2"))
    for name, rows in signals_of(measured).items():
        assert len(rows) == 4
        for run_id, row in rows.items():
            np.testing.assert_array_equal(row, other[name][run_id], err_msg=name)


def test_simulate_gives_the_bits_of_the_sweep(measured, tmp_path):
    alone = ("leakage.internal_coefficient=1e-8", "measurement.seed=1")
    settings = [part for setting in alone for part in ("--set", setting)]
    done = run_hydrofdi(
        "simulate", measured.config, *settings, "--out", "run.h5", "--json", cwd=tmp_path
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    run_id = json.loads(done.stdout)["run_id"]
    swept = signals_of(measured)
    with h5py.File(tmp_path / "run.h5") as file:
        for name in swept:
            np.testing.assert_array_equal(np.atleast_2d(file[name][:])[0], swept[name][run_id], err_msg=name)


def test_replicates_differ_in_what_is_measured_and_agree_in_what_happened(measured):
    with h5py.File(measured.file) as file:
        leaks, seeds = file["internal_leakage_coefficient"][:], file["measurement_seed"][:]
        for leak in (0.0, 1e-8):
            first, second = (np.flatnonzero((leaks == leak) & (seeds == seed))[0] for seed in (0, 1))
            assert not np.array_equal(file["detail_rms"][first], file["detail_rms"][second])
            for name in ("energy_residual", "chamber_1_pressure_max", "internal_leakage_flow", "verdict"):
                np.testing.assert_array_equal(file[name][first], file[name][second])


def test_ready_sweep_over_noise_shows_the_spread_of_the_healthy_actuator(tmp_path):
    config = REPOSITORY / "configs" / "sensor-noise.yaml"
    sweep = swept(tmp_path, config, "--set", "record.duration=2 s")
    table = run_table(read_results(sweep.directory))
    spreads = {}
    sealed = table.of(table.is_sealed)
    for labels, delta in zip(sealed.labels, sealed.changes("fixed"), strict=True):
        if labels["measurement.seed"] < 8:
            spreads.setdefault(labels["pressure_1_sensor.noise"], []).append(delta[0])
    assert [len(values) for values in spreads.values()] == [8, 8, 8]
    deviations = [np.std(spreads[noise]) for noise in (1e3, 5e3, 20e3)]
    assert 0.0 < deviations[0] < deviations[1] < deviations[2]
