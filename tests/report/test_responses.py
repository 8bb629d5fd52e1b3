"""Responses of features over what an experiment varies, their rank correlations, and both in JSON."""

import json

import numpy as np
import pytest
from scipy.stats import spearmanr

from hydrofdi.papers import make_report
from hydrofdi.report.page import render_json
from hydrofdi.report.responses import LEAST_RUNS, rank_correlation, spread, study_responses
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


def test_chance_gives_more_than_its_bound_in_5_percent_of_permutations():
    """Of a feature whose scatter grows with the parameter: ρ is not that of a normal distribution."""
    rng = np.random.default_rng(2)
    parameter = rng.uniform(size=64)
    feature = parameter + parameter * rng.normal(size=64)
    found = [rank_correlation(parameter, rng.permutation(feature)) for _ in range(500)]
    assert 0.025 <= np.mean([abs(each.value) > each.chance for each in found]) <= 0.08


def test_it_is_spearmans_with_ties_and_without_runs_that_lack_a_number():
    rng = np.random.default_rng(4)
    parameter, feature = rng.integers(0, 6, (2, 50)).astype(float)
    expected = spearmanr(parameter[:40], feature[:40]).statistic
    feature[40:] = np.nan
    found = rank_correlation(parameter, feature)
    assert (found.value, found.n_run) == (pytest.approx(expected), 40)
    assert rank_correlation(parameter, -(parameter**3)).value == pytest.approx(-1.0)


def test_too_few_runs_and_constant_features_have_none():
    few, enough = (np.arange(float(n_run)) for n_run in (LEAST_RUNS - 1, LEAST_RUNS))
    assert np.isnan(
        [rank_correlation(few, few).value, rank_correlation(enough, np.ones(LEAST_RUNS)).value]
    ).all()
    assert np.isfinite(rank_correlation(enough, enough).value)


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
    assert (mean["unit"], mean["baseline"], mean["rank_correlation"]) == ("Pa", None, None)
    group = next(each for each in mean["groups"] if each["value"] == "square")
    assert group["n"] == 16
    assert 1e6 < group["low"] < group["median"] < group["high"] < 2e7

    change = responses["fluid.bulk_modulus", "δd2"]
    assert (change["unit"], change["baseline"]) == ("%", "fixed")
    assert sum(group["n"] for group in change["groups"]) == 32
    ends = [end for group in change["groups"] for end in (group["from"], group["to"])]
    assert ends == sorted(ends)
    rows = {row["run_id"]: row["delta_fixed_percent"][1] for row in record["rows"]}
    runs = data.columns[names.RUN_ID].astype(str)[:32]
    expected = spearmanr(np.array(data.values("fluid.bulk_modulus")[:32]), [rows[run] for run in runs])
    rank = change["rank_correlation"]
    assert rank["value"] == pytest.approx(expected.statistic)
    assert (rank["n"], 0.0 < rank["chance"] < 1.0) == (32, True)
