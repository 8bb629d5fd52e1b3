"""Numbers of records that a study needs, said before it is swept."""

import re
import sys

import pytest

import hydrofdi
from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.plausibility import study_mistakes
from hydrofdi.engine import InProcessEngine
from hydrofdi.execution.checks import other_machines, without_results
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.papers import make_report
from hydrofdi.quality.machine import long_steps
from hydrofdi.settings.files import ready_names
from hydrofdi.store.results import read_results

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
    warning, *_ = study_mistakes(loaded(needed - 1, threshold=threshold))
    assert f"{threshold} needs {needed} records" in warning
    assert not any(f"needs {needed} records" in text for text in study_mistakes(loaded(needed)))


@pytest.mark.parametrize(("threshold", "needed"), [("quantile", 199), ("tolerance", 473)])
def test_scores_that_alarm_on_both_sides_need_more_healthy_records(loaded, threshold, needed):
    _, warning = study_mistakes(loaded(20, threshold=threshold))
    assert f"{threshold} needs {needed} records" in warning
    (warning,) = study_mistakes(loaded(needed - 1, threshold=threshold))
    assert f"{threshold} needs {needed} records" in warning
    assert not study_mistakes(loaded(needed, threshold=threshold))


def test_too_few_records_of_shifts_are_warned_of_with_the_number_needed(loaded):
    shifts = "study.shifts={rough: {friction.viscous: 80}}"
    (warning,) = study_mistakes(loaded(199, settings=[shifts, "study.healthy.shift=298"]))
    assert "299" in warning
    for enough in ([shifts], [shifts, "study.healthy.shift=299"], ["study.healthy.shift=298"]):
        assert not study_mistakes(loaded(199, settings=enough))


def test_without_the_extra_reports_judge_the_other_scores(loaded, tmp_path, monkeypatch):
    experiment = loaded(199, settings=["detection.usual_scores=true", "study.healthy.test=20"])
    run_sweep(experiment, tmp_path / "out", InProcessEngine())
    versions = dict(_versions(make_report(read_results(tmp_path / "out"))))
    assert "scikit-learn" in versions
    monkeypatch.setitem(sys.modules, "sklearn", None)
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


def warnings_of(*settings):
    experiment = load_experiment(settings=["record.duration=4 s", *settings])
    return [*without_results(experiment, expand_runs(experiment).runs.distinct)]


def test_a_band_above_half_of_the_sampling_frequency_is_warned_of():
    (sentence,) = warnings_of("indicators={dwt: {}, band_power: {bands: [[400 Hz, 900 Hz]]}}")
    assert sentence.startswith("band_power will have no results: ")
    assert "900 Hz" in sentence
    assert warnings_of("indicators=[dwt, modwt, ring_down, flow_balance]") == []


@pytest.mark.parametrize("sampling", [500.0, 250.0])
def test_the_step_that_is_suggested_is_accepted_and_not_warned_of(tmp_path, sampling):
    file = tmp_path / "step.yaml"
    file.write_text(f"name: step\nrecord: {{duration: 2 s, sampling_frequency: {sampling}}}\n")

    def too_long(step):
        runs = expand_runs(load_experiment(file, [f"record.step={step}"])).runs
        return long_steps(runs.distinct)

    warnings = too_long("1 ms")
    assert warnings
    steps = [float(re.search(r"give record.step: ([\d.]+) ms", text)[1]) for text in warnings]
    assert too_long(f"{min(steps)} ms") == []


STUDY_WARNINGS = """
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
        file.write_text(STUDY_WARNINGS)
        return study_mistakes(load_experiment(file, settings))

    return warnings


def test_too_few_healthy_hours_are_told_with_the_number_needed(warned):
    """Behind the transient a record is watched for 18 s: an hour takes 200 of them."""
    assert not warned()
    for key, stated, needed in (("fit", 199, 200), ("test", 500, 600)):
        (warning,) = warned(f"study.healthy.{key}={stated}")
        assert warning.startswith(f"study.healthy.{key} = {stated} ")
        assert f"needs {needed} " in warning


ANOTHER = "the options describe another machine: "
BASE = """\
name: base
actuator: {piston_area: &area 2099 mm²}
indicators:
  flow_balance: {piston_area: *area, supply: nominal, supply_pressure: 160 bar}
supply: {pressure: 160 bar}
"""


def warnings(folder, text):
    (folder / "base.yaml").write_text(BASE)
    (folder / "child.yaml").write_text("extends: base.yaml\nname: child\n" + text)
    return [each for each in hydrofdi.plan(folder / "child.yaml").warnings if ANOTHER in each]


def test_an_alias_that_keeps_the_value_of_the_extended_file_is_found(tmp_path):
    (warning,) = warnings(tmp_path, "actuator: {piston_area: 1800 mm²}\nsupply: {pressure: 210 bar}\n")
    assert warning.startswith("flow_balance: ")
    assert "piston_area 2099 mm², but actuator.piston_area 1800 mm²" in warning
    assert "supply_pressure 160 bar, but supply.pressure 210 bar" in warning


def test_the_same_machine_or_an_unused_constant_needs_no_warning(tmp_path):
    for text in (
        "",
        "actuator: {piston_area: 1800 mm²}\nindicators: {flow_balance: {piston_area: 1800 mm²}}\n",
        "valve: {natural_frequency: 90 Hz}\nindicators: {flow_balance: {natural_frequency: 175 Hz}}\n",
    ):
        assert not warnings(tmp_path, text)
    for name in (name for name in ready_names() if "/" not in name):
        assert not [*other_machines(load_experiment(name), None)]
