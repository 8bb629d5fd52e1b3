"""Responses of features over what an experiment varies, and both in JSON."""

import json

import numpy as np
import pytest

from hydrofdi.papers import make_report
from hydrofdi.report.page import render_json
from hydrofdi.report.responses import spread, study_responses
from hydrofdi.store import names
from hydrofdi.store.results import read_results
from tests.conftest import sweep_in

MIXED = """\
name: mixed
record: {duration: 1 s}
store: {signals: none}
indicators: [dwt, pressure_statistics]
leakage: {internal_coefficient: 1e-9}
baseline: {fluid.bulk_modulus: 800 MPa}
sweep:
  grid: {input.shape: [square, sine]}
  sample: {count: 16, over: {fluid.bulk_modulus: {uniform: [700 MPa, 900 MPa]}}}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return read_results(sweep_in(tmp_path_factory.mktemp("mixed"), MIXED).directory)


def of(study, axis):
    (found,) = [each for each in study.axes if each.name == axis]
    return found


def test_medians_and_ranges_are_those_of_the_runs_with_that_value(made_up):
    study = study_responses(made_up)
    leak = of(study, "leakage.internal_flow")
    assert (leak.against, [group.text for group in leak.groups]) == ("matched", ["sealed", "0.12", "2"])
    rms = made_up.columns[names.DETAIL_RMS][:, 1]
    deltas = 100.0 * (1.0 - rms[[2, 3]] / rms[[0, 1]])
    small = leak.responses[1].over[1]
    assert (small.median, small.low, small.high) == pytest.approx((deltas.mean(), deltas.min(), deltas.max()))
    assert leak.responses[1].over[0].median == 0.0
    modulus = of(study, "fluid.bulk_modulus")
    assert modulus.against == "fixed"
    assert [each.n_run for each in modulus.responses[0].over] == [3, 2], "the failed run has no number"


def test_the_order_of_the_runs_changes_nothing_and_baselines_that_were_added_are_in_no_group(data):
    study, order = study_responses(data), np.random.default_rng(0).permutation(data.n_run)
    axis = of(study, "fluid.bulk_modulus")
    for response in axis.responses:
        for group, found in zip(axis.groups, response.over, strict=True):
            assert spread(response.feature.values[order][group.rows[order]]) == found
    assert int(study.runs.sum()) == sum(int(group.rows.sum()) for group in axis.groups) == 32 < data.n_run
    assert np.isnan(axis.drawn[~study.runs]).all()


def test_where_each_run_is_its_own_baseline_the_features_stand_themselves(tmp_path):
    text = "name: own\nrecord: {duration: 1 s}\nsweep: {grid: {supply.pressure: [12 MPa, 18 MPa]}}\n"
    (found,) = study_responses(read_results(sweep_in(tmp_path, text).directory)).axes
    assert (found.header, found.against) == ("supply.pressure [MPa]", "")
    assert found.responses[0].feature.header == "RMS of d1 [kPa]"
    assert found.responses[0].over[0].median != found.responses[0].over[1].median


def test_what_varied_and_responses_to_it_stand_in_the_json_in_si_with_their_runs(data):
    record = json.loads(render_json(make_report(data)))
    varied = {each["name"]: each for each in record["varied"]}
    modulus, shape = varied["fluid.bulk_modulus"], varied["input.shape"]
    assert (shape["values"], shape["n"], shape["unit"]) == (["square", "sine"], [16, 16], None)
    assert (modulus["unit"], modulus["n"]) == ("Pa", 32)
    assert list(modulus["quantiles"]) == ["0.05", "0.25", "0.5", "0.75", "0.95"]
    assert sorted([7e8, *modulus["quantiles"].values(), 9e8]) == [7e8, *modulus["quantiles"].values(), 9e8]

    responses = {(each["axis"], each["feature"]): each for each in record["responses"]}
    mean = responses["input.shape", "pressure_statistics.mean"]
    assert (mean["unit"], mean["baseline"]) == ("Pa", None)
    group = next(each for each in mean["groups"] if each["value"] == "square")
    assert group["n"] == 16
    assert 1e6 < group["low"] < group["median"] < group["high"] < 2e7

    change = responses["fluid.bulk_modulus", "δd2"]
    assert (change["unit"], change["baseline"]) == ("%", "fixed")
    assert sum(group["n"] for group in change["groups"]) == 32
    ends = [end for group in change["groups"] for end in (group["from"], group["to"])]
    assert ends == sorted(ends)
