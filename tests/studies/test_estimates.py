"""Estimates of a study against the truth behind its records."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.execution import InProcessEngine
from hydrofdi.report.estimates import estimates_block
from hydrofdi.studies.truth import judge_estimates

STUDY = """
name: small
record: {duration: 4 s, sampling_frequency: 500 Hz}
input: {period: 1 s}
pressure_1_sensor: {noise: 5 kPa}
pressure_2_sensor: {noise: 5 kPa}
position_sensor: {noise: 10 µm}
study:
  population: {seed: 3}
  healthy: {fit: 6, test: 12, shift: 5}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 4, fit: 2}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
detection: {false_alarm_rate: 20 %, confidence: 90 %}
indicators: {balance: {kind: flow_balance, spool: command, supply: nominal}, dwt: {}}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("estimates")
    (folder / "study.yaml").write_text(STUDY)
    run_sweep(load_experiment(folder / "study.yaml"), folder / "results", InProcessEngine())
    return read_results(folder / "results")


def judged(data):
    (estimates,) = judge_estimates(data)
    return {(each.quantity, each.population): each for each in estimates.judgements}


def with_columns(data, **changed):
    return replace(data, columns={**data.columns, **changed})


def test_quantities_with_a_stated_deviation_are_judged_on_test_records_and_shifts(data):
    found = judged(data)
    assert found.keys() == {
        (quantity, population)
        for quantity in ("internal_coefficient", "bulk_modulus")
        for population in ("healthy", "stiffer", "faults")
    }
    assert {population: found["bulk_modulus", population].n for _, population in found} == {
        "healthy": 12, "stiffer": 5, "faults": 8,
    }  # fmt: skip


def test_the_truth_with_a_known_error_gives_this_error_and_its_coverage(data):
    truth, n = data.columns["internal_leakage_coefficient"], data.n_run
    draw = np.random.default_rng(5)
    error = 2e-10 + 1e-9 * draw.normal(size=n)
    told = with_columns(
        data,
        **{
            "balance.internal_coefficient": truth + error,
            "balance.internal_coefficient_error": np.full(n, 1e-9),
        },
    )
    faults = judged(told)["internal_coefficient", "faults"]
    assert faults.stated == pytest.approx(1e-9)
    assert abs(faults.bias) < 2e-9
    assert 1e-10 < faults.deviation < 3e-9
    never = with_columns(told, **{"balance.internal_coefficient_error": np.full(n, 1e-15)})
    assert judged(never)["internal_coefficient", "faults"].covered.count == 0
    always = with_columns(told, **{"balance.internal_coefficient_error": np.full(n, 1e-3)})
    assert judged(always)["internal_coefficient", "faults"].covered.count == 8


def test_bulk_moduli_are_judged_as_shares_of_the_truth(data):
    told = with_columns(data, **{"balance.bulk_modulus": 1.03 * data.columns["bulk_modulus"]})
    for population in ("healthy", "stiffer", "faults"):
        each = judged(told)["bulk_modulus", population]
        assert each.bias == pytest.approx(0.03)
        assert each.deviation < 1e-9


def test_records_without_an_estimate_are_counted_apart(data):
    some = data.columns["balance.bulk_modulus"].copy()
    some[:] = np.nan
    each = judged(with_columns(data, **{"balance.bulk_modulus": some}))["bulk_modulus", "healthy"]
    assert (each.n, each.not_measurable, each.covered.total) == (0, 12, 0)
    assert np.isnan(each.bias)


def test_leaks_that_set_in_later_are_left_out_with_the_reason(data):
    """Neither K_i nor β of such a record has one truth."""
    leakage = data.experiment.leakage.model_copy(update={"onset": "step", "onset_time": 2.0})
    later = replace(data, experiment=data.experiment.model_copy(update={"leakage": leakage}))
    assert {population for _, population in judged(later)} == {"healthy", "stiffer"}
    (sheet,) = estimates_block(judge_estimates(later)[0]).tables
    assert "Faults are left out: leaks set in during the record" in sheet.notes[0]
    (sheet,) = estimates_block(judge_estimates(data)[0]).tables
    assert "left out" not in sheet.notes[0]
