"""What charts cannot state is said before a sweep."""

import pytest

from hydrofdi.api.warnings import STUDY_RULES, said
from hydrofdi.config import load_experiment

STUDY = """
name: few
record: {duration: 20 s}
leakage: {onset: step, onset_time: 10 s}
baseline: {leakage.onset: constant}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 200, test: 600}
  faults: {leakage.internal_flow: [0.2 L/min], each: 29}
indicators: {weak_rls: {spool: command, supply: sum, transient: 2 s, trace_duration: 20 s}}
detection:
  false_alarm_rate: 5 %
  online:
    false_alarm_every: 1 h
    charts: {cusum: {of: weak_rls.leakage, chart: cusum}}
"""


@pytest.fixture
def warned(tmp_path):
    def warnings(*settings):
        file = tmp_path / "few.yaml"
        file.write_text(STUDY)
        return said(STUDY_RULES, load_experiment(file, settings), None)

    return warnings


def test_a_study_that_can_state_all_is_not_warned_of(warned):
    assert not warned()


def test_too_few_healthy_hours_are_told_with_the_number_needed(warned):
    """Behind the transient a record is watched for 18 s: an hour takes 200 of them."""
    (fit,) = warned("study.healthy.fit=199")
    assert fit.startswith("study.healthy.fit = 199 ")
    assert "needs 200 " in fit
    (test,) = warned("study.healthy.test=500")
    assert test.startswith("study.healthy.test = 500 ")
    assert "needs 600 " in test
