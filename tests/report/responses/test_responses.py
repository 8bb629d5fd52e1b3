"""Responses of features over what an experiment varies."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.report.responses import spread, study_responses
from hydrofdi.store.layout import names
from tests.conftest import sweep_in

SAMPLED = """\
name: sampled
record: {duration: 1 s}
store: {signals: none}
sweep:
  sample:
    count: 64
    over:
      fluid.bulk_modulus: {uniform: [700 MPa, 900 MPa]}
      supply.pressure: {uniform: [16 MPa, 18 MPa]}
"""


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    return read_results(sweep_in(tmp_path_factory.mktemp("sampled"), SAMPLED).directory)


def of(study, axis):
    (found,) = [each for each in study.axes if each.axis.name == axis]
    return found


def test_medians_and_ranges_are_those_of_the_runs_with_that_value(made_up):
    study = study_responses(made_up)
    leak = of(study, "leakage.internal_flow")
    assert (leak.against, [group.text for group in leak.axis.groups]) == ("matched", ["sealed", "0.12", "2"])
    rms = made_up.columns[names.DETAIL_RMS][:, 1]
    deltas = 100.0 * (1.0 - rms[[2, 3]] / rms[[0, 1]])
    small = leak.responses[1].over[1]
    assert (small.median, small.low, small.high) == pytest.approx((deltas.mean(), deltas.min(), deltas.max()))
    assert leak.responses[1].over[0].median == 0.0
    modulus = of(study, "fluid.bulk_modulus")
    assert modulus.against == "fixed"
    assert [each.n_run for each in modulus.responses[0].over] == [3, 2], "the failed run has no number"


def test_a_constant_feature_has_response_0(made_up):
    same = replace(made_up, columns=made_up.columns | {names.DETAIL_RMS: np.full((6, 5), 1e5)})
    for found in study_responses(same).axes:
        for response in found.responses:
            assert {(each.median, each.low, each.high) for each in response.over} == {(0.0, 0.0, 0.0)}


def test_the_order_of_the_runs_changes_nothing(sampled):
    order = np.random.default_rng(0).permutation(sampled.n_run)
    study = study_responses(sampled)
    axis = of(study, "fluid.bulk_modulus")
    for response in axis.responses:
        for group, found in zip(axis.axis.groups, response.over, strict=True):
            shuffled = response.feature.values[order][group.rows[order]]
            assert spread(shuffled) == found


def test_baselines_that_were_added_are_in_no_group(sampled):
    study = study_responses(sampled)
    assert int(study.runs.sum()) == 64 < sampled.n_run
    axis = of(study, "fluid.bulk_modulus").axis
    assert axis.drawn is not None
    assert np.nanmin(axis.numbers) > 690e6, "the baseline at 551 MPa is none of the draws"
    assert sum(int(group.rows.sum()) for group in axis.groups) == 64


def test_sampled_parameters_have_a_rank_correlation_and_grids_have_none(sampled, made_up):
    ranks = [response.rank for response in of(study_responses(sampled), "fluid.bulk_modulus").responses]
    assert ranks[0].value < -0.8, "the RMS of d1 rises with the modulus, so that δd1 falls"
    assert ranks[0].n_run == 64
    assert {r.rank for found in study_responses(made_up).axes for r in found.responses} == {None}


def test_where_each_run_is_its_own_baseline_the_features_stand_themselves(tmp_path):
    text = "name: own\nrecord: {duration: 1 s}\nsweep: {grid: {supply.pressure: [12 MPa, 18 MPa]}}\n"
    (found,) = study_responses(read_results(sweep_in(tmp_path, text).directory)).axes
    assert (found.axis.header, found.against) == ("supply.pressure [MPa]", "")
    assert found.responses[0].feature.header == "RMS of d1 [kPa]"
    assert found.responses[0].over[0].median != found.responses[0].over[1].median
