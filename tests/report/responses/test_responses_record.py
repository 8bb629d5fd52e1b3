"""Responses in JSON: the numbers of the tables, in SI."""

import json

import numpy as np
import pytest
from scipy.stats import spearmanr

from hydrofdi.api.stored import read_results
from hydrofdi.papers import make_report
from hydrofdi.report.record import render_json
from hydrofdi.store.layout import names
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


@pytest.fixture(scope="module")
def record(data):
    return json.loads(render_json(make_report(data)))


def of(record, axis, feature):
    (found,) = [each for each in record["responses"] if (each["axis"], each["feature"]) == (axis, feature)]
    return found


def test_what_was_varied_has_values_or_quantiles_with_the_runs(record):
    varied = {each["name"]: each for each in record["varied"]}
    modulus, shape = varied["fluid.bulk_modulus"], varied["input.shape"]
    assert (shape["values"], shape["n"], shape["unit"]) == (["square", "sine"], [16, 16], None)
    assert (modulus["unit"], modulus["n"]) == ("Pa", 32)
    quantiles = list(modulus["quantiles"].values())
    assert list(modulus["quantiles"]) == ["0.05", "0.25", "0.5", "0.75", "0.95"]
    assert quantiles == sorted(quantiles)
    assert quantiles[0] >= 7e8
    assert quantiles[-1] <= 9e8


def test_groups_of_an_output_are_in_si_whatever_the_tables_show(record, data):
    mean = of(record, "input.shape", "pressure_statistics.mean")
    assert (mean["unit"], mean["baseline"], mean["rank_correlation"]) == ("Pa", None, None)
    group = next(each for each in mean["groups"] if each["value"] == "square")
    assert group["n"] == 16
    assert 1e6 < group["low"] < group["median"] < group["high"] < 2e7


def test_a_sampled_parameter_has_fifths_and_a_rank_correlation(record, data):
    change = of(record, "fluid.bulk_modulus", "δd2")
    assert (change["unit"], change["baseline"]) == ("%", "fixed")
    assert sum(group["n"] for group in change["groups"]) == 32
    ends = [end for group in change["groups"] for end in (group["from"], group["to"])]
    assert ends == sorted(ends)
    rows = {row["run_id"]: row["delta_fixed_percent"][1] for row in record["rows"]}
    runs = data.columns[names.RUN_ID].astype(str)[:32]
    expected = spearmanr(np.array(data.values("fluid.bulk_modulus")[:32]), [rows[run] for run in runs])
    rank = change["rank_correlation"]
    assert rank["value"] == pytest.approx(expected.statistic)
    assert rank["low"] <= rank["value"] <= rank["high"]
    assert (rank["n"], 0.0 < rank["chance"] < 1.0) == (32, True)
