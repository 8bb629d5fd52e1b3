"""Numbers of records that a study needs, said before it is swept."""

import sys

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.api.warnings import STUDY_RULES, said
from hydrofdi.config import load_experiment
from hydrofdi.execution import InProcessEngine
from hydrofdi.papers import make_report

STUDY = """
name: few
record: {{duration: 2 s}}
study:
  population: {{over: {{fluid.bulk_modulus: {{uniform: ±20 %}}}}}}
  healthy: {{fit: {fit}, test: 299}}
  faults: {{leakage.internal_flow: [0.2 L/min, 1 L/min], each: {each}, fit: 10}}
detection: {{threshold: {threshold}, indicators: [pressure_statistics]}}
"""


@pytest.fixture
def loaded(tmp_path):
    def load(fit, each=29, threshold="quantile", settings=()):
        file = tmp_path / "few.yaml"
        file.write_text(STUDY.format(fit=fit, each=each, threshold=threshold))
        return load_experiment(file, settings)

    return load


@pytest.mark.parametrize(("threshold", "needed"), [("quantile", 99), ("tolerance", 299), ("tail", 500)])
def test_too_few_healthy_records_are_warned_of_with_the_number_needed(loaded, threshold, needed):
    (warning,) = said(STUDY_RULES, loaded(needed - 1, threshold=threshold), None)
    assert f"{threshold} needs {needed} records" in warning
    assert not any(f"needs {needed} records" in text for text in said(STUDY_RULES, loaded(needed), None))


@pytest.mark.parametrize(("threshold", "needed"), [("quantile", 199), ("tolerance", 473)])
def test_scores_that_alarm_on_both_sides_need_more_healthy_records(loaded, threshold, needed):
    (warning,) = said(STUDY_RULES, loaded(20, threshold=threshold), None)
    assert f", and {needed} for scores that may alarm on both sides, such as pressure_" in warning
    (warning,) = said(STUDY_RULES, loaded(needed - 1, threshold=threshold), None)
    assert "sets no threshold for scores that may alarm on both sides, such as pressure_" in warning
    assert f"{threshold} needs {needed} records" in warning
    assert not said(STUDY_RULES, loaded(needed, threshold=threshold), None)


def test_too_few_records_of_shifts_are_warned_of_with_the_number_needed(loaded):
    shifts = "study.shifts={rough: {friction.viscous: 80}}"
    (warning,) = said(STUDY_RULES, loaded(199, settings=[shifts, "study.healthy.shift=298"]), None)
    assert "study.healthy.shift = 298 shows no rate" in warning
    assert "1 % needs 299 records of each" in warning
    for enough in ([shifts], [shifts, "study.healthy.shift=299"], ["study.healthy.shift=298"]):
        assert not said(STUDY_RULES, loaded(199, settings=enough), None)


@pytest.mark.parametrize(("changes", "is_inside"), [
    ("fluid.bulk_modulus: 600 MPa", True),
    ("fluid.bulk_modulus: +5 %", True),
    ("fluid.bulk_modulus: 689 MPa", False),
    ("fluid.bulk_modulus: 600 MPa, friction.viscous: 80", False),
    ("friction.viscous: 80", False),
])  # fmt: skip
def test_a_shift_inside_the_population_is_warned_of(loaded, changes, is_inside):
    warnings = said(STUDY_RULES, loaded(199, settings=[f"study.shifts={{warm: {{{changes}}}}}"]), None)
    found = [each for each in warnings if each.startswith("study.shifts.warm: fluid.bulk_modulus = ")]
    assert len(found) == is_inside


def test_without_the_extra_plans_warn_and_reports_judge_the_other_scores(loaded, tmp_path, monkeypatch):
    experiment = loaded(199, settings=["detection.usual_scores=true", "study.healthy.test=20"])
    run_sweep(experiment, tmp_path / "out", InProcessEngine())
    versions = dict(_versions(make_report(read_results(tmp_path / "out"))))
    assert "scikit-learn" in versions
    monkeypatch.setitem(sys.modules, "sklearn", None)
    assert any("pip install 'hydrofdi[learn]'" in text for text in said(STUDY_RULES, experiment, None))
    report = make_report(read_results(tmp_path / "out"))
    names = [each.scored.name for each in report.detections[0].judgements]
    assert names
    assert all(name.startswith("pressure_statistics.") for name in names)
    (remark,) = [text for text in report.detections[0].remarks if "omitted because" in text]
    assert "mahalanobis(P1)" in remark
    assert "scikit-learn" not in dict(_versions(report))


def _versions(report):
    (block,) = [block for block in report.document().blocks if block.key == "provenance"]
    (table,) = [table for table in block.tables if table.key == "versions"]
    return [(row["Library"], row["Version"]) for row in table]
