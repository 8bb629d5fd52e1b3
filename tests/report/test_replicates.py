"""Healthy replicates: baselines that a run is not part of, and how far healthy actuators differ."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

from hydrofdi.api.stored import read_results
from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.papers import make_report
from hydrofdi.report.runs import run_table
from hydrofdi.report.views import replicates_view
from hydrofdi.store.layout import names
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

REPLICATED = """\
name: replicated
record: {duration: 2 s}
store: {signals: none}
pressure_1_sensor: {noise: 5 kPa}
replicates:
  count: 6
  seed: 4
  over: {friction.viscous: {uniform: [40, 60]}}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-9]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


def _experiment(tmp_path: Path, text: str = REPLICATED):
    config = tmp_path / "replicated.yaml"
    config.write_text(text)
    return load_experiment(config)


def test_each_healthy_run_has_its_own_replicates(tmp_path):
    table = expand_runs(_experiment(tmp_path))
    of_run = table.replicate_of
    assert len(table.runs) == 4 + 2 * 6
    assert sorted(set(of_run[of_run >= 0].tolist())) == [0, 1], "the sealed runs at either EBM"
    replicas = [table.runs[int(k)].parameters for k in np.flatnonzero(of_run == 1)]
    healthy = table.runs[1].parameters
    assert {run.fluid.bulk_modulus for run in replicas} == {healthy.fluid.bulk_modulus}
    assert all(not run.leakage.internal_coefficient for run in replicas)
    viscous = [run.friction.viscous for run in replicas]
    assert len(set(viscous)) == 6
    assert all(40.0 <= value <= 60.0 for value in viscous)
    assert healthy.measurement.seed not in {run.measurement.seed for run in replicas}
    others = [table.runs[int(k)].parameters.friction.viscous for k in np.flatnonzero(of_run == 0)]
    assert not set(viscous) & set(others), "drawn anew for each healthy run"


def test_replicates_leave_all_other_runs_alone(tmp_path):
    with_, without = (
        expand_runs(_experiment(tmp_path, text))
        for text in (REPLICATED, REPLICATED.replace("count: 6", "count: 0"))
    )
    for position in range(4):
        assert with_.runs[position].record_digest == without.runs[position].record_digest
    assert len(without.runs) == 4
    np.testing.assert_array_equal(with_.fixed_baseline[:4], without.fixed_baseline)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("replicated"), REPLICATED)


def test_a_sealed_run_is_not_its_own_baseline(swept):
    record = json.loads(run_hydrofdi("report", "--json", cwd=swept.folder).stdout)
    assert len(record["rows"]) == 4, "replicates are no rows of the table"
    sealed = {row["run_id"] for row in record["rows"] if row["sealed"]}
    found = [
        row
        for row in record["replicates"]["rows"]
        if row["run_id"] in sealed and row["baseline"] == "matched"
    ]
    assert len(found) == 2
    assert all(abs(value) > 1e-6 for row in found for value in row["delta_percent"])
    assert {span["replicates"] for span in record["replicates"]["ranges"]} == {6}


def test_the_file_says_what_a_run_is_a_replicate_of(swept):
    with xarray.open_dataset(swept.file, engine="h5netcdf") as runs:
        assert (runs.replicate_of_run.values[:4] == -1).all()
        assert set(runs.replicate_of_run.values[4:].tolist()) == {0, 1}
        assert (runs.status == "ok").all()


def test_a_healthy_run_lies_outside_of_the_range_as_often_as_is_said(swept):
    """Runs and replicates alike: 2 of n + 1 lie outside, up to what mean and range share."""
    data = read_results(swept.directory)
    table = run_table(data)
    generator, n_repeat, outside = np.random.default_rng(11), 1500, 0
    for _ in range(n_repeat):
        rms = generator.normal(100.0, 5.0, data.columns[names.DETAIL_RMS].shape)
        drawn = replace(data, columns=data.columns | {names.DETAIL_RMS: rms})
        _, record = replicates_view(table, drawn)
        rows = record["replicates"]["rows"]
        first = next(row for row in rows if row["baseline"] == "matched")
        outside += sum(first["outside_healthy_range"])
    share = outside / (5 * n_repeat)
    assert 0.15 < share < 2.0 / 7.0 + 0.02


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("count: 6", "count: 1"),
        ("friction.viscous: {", "friction.viscus: {"),
        ("[40, 60]", "[-40, 60]"),
        ("friction.viscous: {uniform: [40, 60]}", "leakage.internal_flow: {uniform: [0, 1e-5]}"),
    ],
)
def test_replicates_that_make_no_sense_are_mistakes(tmp_path, old, new):
    with pytest.raises(ConfigError):
        expand_runs(_experiment(tmp_path, REPLICATED.replace(old, new)))


def test_noise_alone_makes_replicates_differ(tmp_path):
    text = REPLICATED.replace("  over: {friction.viscous: {uniform: [40, 60]}}\n", "")
    expand_runs(_experiment(tmp_path, text))
    with pytest.raises(ConfigError):
        expand_runs(_experiment(tmp_path, text.replace("pressure_1_sensor: {noise: 5 kPa}\n", "")))


def test_a_replicate_that_has_not_settled_is_counted_as_left_out(tmp_path):
    text = REPLICATED.replace("record: {duration: 2 s}", "record: {duration: 12 s}\ninput: {period: 1 s}")
    data = read_results(sweep_in(tmp_path, text.replace("[551 MPa, 689 MPa]", "[551 MPa]")).directory)
    settled = data.columns[names.SETTLED_DETAIL_RMS].copy()
    settled[-1] = np.nan
    data = replace(data, columns=data.columns | {names.SETTLED_DETAIL_RMS: settled})
    (block,) = [block for block in make_report(data).document().blocks if block.key == "replicates"]
    assert "1 replicate" in block.paragraphs[-1]
