"""Leaks against what differs between sealed actuators: noise, and what is drawn."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.report.runs import run_table
from hydrofdi.report.views import healthy_view
from hydrofdi.store import names
from hydrofdi.store.results import read_results
from tests.conftest import sweep_in

VARIED = """\
name: varied
record: {duration: 2 s}
store: {signals: none}
pressure_1_sensor: {noise: 5 kPa}
sweep:
  grid:
    leakage.internal_coefficient: [0, 1e-8]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
    measurement.seed: {arange: [0, 7, 1]}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return read_results(sweep_in(tmp_path_factory.mktemp("varied"), VARIED).directory)


def with_rms(data, rms):
    return run_table(replace(data, columns=data.columns | {names.DETAIL_RMS: rms}))


def test_each_run_is_compared_with_the_other_sealed_ones_at_its_bulk_modulus(data):
    rms = data.columns[names.DETAIL_RMS]
    rows = {run_id: k for k, run_id in enumerate(data.columns[names.RUN_ID].astype(str))}
    block, record = healthy_view(run_table(data))
    groups = [([rows[each] for each in group["run_id"]], group) for group in record["healthy_ranges"]]
    assert [len(own) for own, _ in groups] == [7] * 4
    for (sealed, of_sealed), (leaky, of_leaky) in (groups[:2], groups[2:]):
        assert len({*data.columns[names.BULK_MODULUS][[*sealed, *leaky]]}) == 1
        mean = rms[sealed].mean(axis=0)
        np.testing.assert_allclose(of_leaky["delta_percent"], 100 * (mean - rms[leaky]) / mean)
        others = rms[sealed[1:]].mean(axis=0)
        np.testing.assert_allclose(of_sealed["delta_percent"][0], 100 * (others - rms[sealed[0]]) / others)
    d2 = next(column for column in block.tables[0].content if column.name == "δd2 [%]")
    assert [*d2.strong] == [1, 3]


def test_another_sealed_run_lies_outside_of_the_range_as_often_as_is_said(data):
    generator, n_repeat, outside, n_emphasized = np.random.default_rng(11), 1500, 0, 0
    for _ in range(n_repeat):
        rms = generator.normal(100.0, 5.0, data.columns[names.DETAIL_RMS].shape)
        block, record = healthy_view(with_rms(data, rms))
        sealed, leaky = (np.array(group["delta_percent"]) for group in record["healthy_ranges"][:2])
        n_emphasized += sum(len(column.strong) for column in block.tables[0].content)
        outside += ((leaky[0] < sealed.min(axis=0)) | (leaky[0] > sealed.max(axis=0))).sum()
    assert 0.15 < outside / (5 * n_repeat) < 2 / 8 + 0.02
    assert n_emphasized / (10 * n_repeat) < 0.002


def test_runs_that_failed_are_left_out_and_drawn_leaks_have_no_such_ranges(data):
    rms = data.columns[names.DETAIL_RMS].copy()
    rms[0] = np.nan
    assert len(healthy_view(with_rms(data, rms))[1]["healthy_ranges"][0]["run_id"]) == 6
    assert healthy_view(with_rms(data, np.full_like(rms, np.nan))) is None
    over = {"leakage.internal_flow": {"uniform": ["0 L/min", "1 L/min"]}}
    drawn = load_experiment({"name": "drawn", "sweep": {"sample": {"count": 4, "over": over}}})
    assert healthy_view(run_table(replace(data, experiment=drawn))) is None
