"""Sweeps of many runs: counted before they are expanded, and the same as one by one."""
# ruff: noqa: E501

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.run_table.runs import run_identities, run_identity
from hydrofdi.config.sweeps.points import count_points
from hydrofdi.config.sweeps.sweep import distinct_rows
from hydrofdi.errors import ConfigError

EBM = "sweep.grid.fluid.bulk_modulus={linspace: [500 MPa, 900 MPa, %d]}"
VISCOUS = "sweep.grid.friction.viscous={linspace: [10, 100, %d]}"
FLOW = "leakage.internal_flow=0.5 L/min"


@pytest.mark.parametrize(
    ("settings", "count"),
    [
        ([EBM % 10_000, VISCOUS % 1000], "10,000,000"),
        ([EBM % 1000, VISCOUS % 1000, "sweep.zip.friction.coulomb=[160, 200]"], "2,000,000"),
        ([EBM % 1000, "ensemble.sample={count: 1001, over: {friction.viscous: {uniform: [1, 2]}}}"], "1,001,000"),
        ([EBM % 1000, VISCOUS % 1001, "sweep.where=fluid.bulk_modulus < 1"], "1,001,000"),
    ],
)  # fmt: skip
def test_a_sweep_that_is_too_large_is_refused_with_its_size_before_it_takes_memory(settings, count):
    experiment = load_experiment(None, settings)
    tracemalloc.start()
    try:
        with pytest.raises(ConfigError, match=f"sweep: {count} runs exceed the limit of 1,000,000 per sweep"):
            expand_runs(experiment)
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


def test_points_are_counted_block_by_block():
    part = "{grid: {friction.coulomb: [1, 2, 3]}, zip: {valve.lap: [0, 1e-5]}}"
    settings = [
        EBM % 7,
        f"sweep.union=[{part}, {{sample: {{count: 5, over: {{actuator.mass: {{choice: [9, 10]}}}}}}}}]",
    ]
    assert count_points(load_experiment(None, settings).sweep) == 7 * (3 * 2 + 5)
    assert count_points(load_experiment().sweep) == 1


def test_a_hundred_thousand_runs_share_what_they_have_in_common():
    experiment = load_experiment(None, [EBM % 300, VISCOUS % 300, FLOW])
    tracemalloc.start()
    try:
        table = expand_runs(experiment)
        held, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(table.runs) == 2 * 90_000 + 300
    assert held / len(table.runs) < 100, "bytes per run"
    assert most / len(table.runs) < 500, "bytes per run"
    assert len({id(run.parameters.friction) for run in table.runs[:600]}) == 300
    assert vars(table.runs.solutions()) == {"flows": 1, "conditions": 300, "total": 300}


SETTINGS = [
    [EBM % 3, VISCOUS % 4, FLOW, "baseline.friction.coulomb=150"],
    [EBM % 2, "sweep.grid.measurement.seed=[1, 2]", "pressure_1_sensor.noise=1 kPa", FLOW],
    ["sweep.grid.leakage.internal_flow=[0, 1e-5]", "ensemble.grid.friction.law=[smooth, lugre]"],
    [],
]


@pytest.mark.parametrize("settings", SETTINGS)
def test_runs_made_together_are_those_made_one_by_one(settings):
    experiment = load_experiment(None, settings)
    table = expand_runs(experiment)
    assert run_identities(table.runs) == tuple(run_identity(run) for run in table.runs)
    assert len(set(run_identities(table.runs))) == len(table.runs)
    for position, run in enumerate(table.runs):
        healthy = run.parameters.with_values(experiment.baseline)
        fixed = table.runs[int(table.fixed_baseline[position])].parameters
        assert fixed.fluid == healthy.fluid
        assert fixed.friction == healthy.friction
        assert not fixed.leakage.needs_calibration
        matched = table.runs[int(table.matched_baseline[position])].parameters
        assert matched.with_sections({"leakage": run.parameters.leakage}) == run.parameters


def test_values_slices_and_distinct_runs_are_those_of_the_runs():
    table = expand_runs(load_experiment(None, [EBM % 5, VISCOUS % 3, FLOW]))
    runs = list(table.runs)
    for name in ("fluid.bulk_modulus", "friction.viscous", "actuator.mass", "leakage.internal_flow"):
        assert table.runs.values(name) == [run.parameters.value(name) for run in runs]
    assert [run.parameters for run in table.runs[4:20:3]] == [run.parameters for run in runs[4:20:3]]
    assert table.runs[-1].parameters == runs[-1].parameters
    assert len(list(table.runs.distinct("fluid"))) == 6, "with that of the baseline"
    assert len(list(table.runs.distinct("fluid", "friction"))) == 18
    with pytest.raises(IndexError):
        table.runs[len(runs)]


@given(st.lists(st.tuples(*[st.integers(-1, 3)] * 3), min_size=1, max_size=40))
def test_distinct_rows_are_reported_in_order_of_appearance(rows):
    columns = list(np.array(rows, dtype=np.int32).T)
    first, inverse = distinct_rows(columns, len(rows))
    different = list(dict.fromkeys(rows))
    assert [rows[k] for k in first] == different
    assert [different[k] for k in inverse] == rows


def test_distinct_rows_of_many_columns_do_not_overflow():
    columns = [np.random.default_rng(k).permutation(70_000).astype(np.int32) for k in range(6)]
    first, inverse = distinct_rows([*columns, *columns], 70_000)
    assert np.array_equal(first, np.arange(70_000))
    assert np.array_equal(inverse, first)
