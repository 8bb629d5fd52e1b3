"""Numbers of records that a study needs, said before it is swept."""

import re
import sys

import pytest
import yaml

import hydrofdi
from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.execution.checks import STUDY_RULES, other_machines, said, without_results
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.papers import make_report
from hydrofdi.quality.machine import long_steps
from hydrofdi.settings.files import ready_names
from hydrofdi.store.results import read_results

STUDY = yaml.safe_load("""
name: few
record: {duration: 2 s}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {test: 299}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 29, fit: 10}
detection: {indicators: [pressure_statistics]}
""")
SHIFT = "study.shifts={rough: {friction.viscous: 80}}"


def told(*settings, base=STUDY):
    return [*said(STUDY_RULES, load_experiment(base, settings), None)]


@pytest.mark.parametrize(
    ("threshold", "needed", "of_both"), [("quantile", 99, 199), ("tolerance", 299, 473), ("tail", 500, None)]
)
def test_too_few_healthy_records_are_warned_of_with_the_number_needed(threshold, needed, of_both):
    rule = f"detection.threshold={threshold}"
    warning, *_ = told(rule, f"study.healthy.fit={needed - 1}")
    assert f"{threshold} needs {needed} records" in warning
    assert not any(f"needs {needed} records" in text for text in told(rule, f"study.healthy.fit={needed}"))
    if of_both:
        assert f"{threshold} needs {of_both} records" in told(rule, "study.healthy.fit=20")[1]
        (warning,) = told(rule, f"study.healthy.fit={of_both - 1}")
        assert f"{threshold} needs {of_both} records" in warning
        assert not told(rule, f"study.healthy.fit={of_both}")


def test_too_few_records_of_shifts_are_warned_of_with_the_number_needed():
    enough = "study.healthy.fit=199"
    (warning,) = told(enough, SHIFT, "study.healthy.shift=298")
    assert "299" in warning
    for settings in ([SHIFT], [SHIFT, "study.healthy.shift=299"], ["study.healthy.shift=298"]):
        assert not told(enough, *settings)


def test_without_the_extra_reports_judge_the_other_scores(tmp_path, monkeypatch):
    few = ("study.healthy.fit=199", "study.healthy.test=20")
    experiment = load_experiment(STUDY, ["detection.usual_scores=true", *few])
    run_sweep(experiment, tmp_path / "out", InProcessEngine())
    assert "scikit-learn" in libraries(make_report(read_results(tmp_path / "out")))
    monkeypatch.setitem(sys.modules, "sklearn", None)
    report = make_report(read_results(tmp_path / "out"))
    names = [each.scored.name for each in report.detections[0].judgements]
    assert {name.partition(".")[0] for name in names} == {"pressure_statistics"}
    (remark,) = [text for text in report.detections[0].remarks if "omitted because" in text]
    assert "mahalanobis(P1)" in remark
    assert "scikit-learn" not in libraries(report)


def libraries(report):
    (block,) = [block for block in report.document().blocks if block.key == "provenance"]
    (table,) = [table for table in block.tables if table.key == "versions"]
    return [row["Library"] for row in table]


def test_an_indicator_that_will_have_no_results_is_warned_of():
    def warnings_of(*settings):
        experiment = load_experiment(settings=["record.duration=4 s", *settings])
        return [*without_results(experiment, expand_runs(experiment).runs.distinct)]

    (sentence,) = warnings_of("indicators={dwt: {}, band_power: {bands: [[400 Hz, 900 Hz]]}}")
    assert sentence.startswith("band_power will have no results: ")
    assert "900 Hz" in sentence
    assert warnings_of("indicators=[dwt, modwt, ring_down, flow_balance]") == []
    (sentence,) = warnings_of("indicators=[pressure_balance]", "actuator.load_stiffness=0 N/m")
    assert sentence.startswith("pressure_balance will have no results: ")
    assert warnings_of("indicators=[pressure_balance]") == []


@pytest.mark.parametrize("sampling", [500.0, 250.0])
def test_the_step_that_is_suggested_is_accepted_and_not_warned_of(sampling):
    def too_long(step):
        record = {"duration": "2 s", "sampling_frequency": sampling, "step": step}
        return long_steps(expand_runs(load_experiment({"record": record})).runs.distinct)

    warnings = too_long("1 ms")
    steps = [float(re.search(r"give record.step: ([\d.]+) ms", text)[1]) for text in warnings]
    assert too_long(f"{min(steps)} ms") == []


ONLINE = yaml.safe_load("""
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
  online: {false_alarm_every: 1 h, charts: {cusum: {of: weak_rls.leakage, chart: cusum}}}
""")


def test_too_few_healthy_hours_are_told_with_the_number_needed():
    """Behind the transient a record is watched for 18 s: an hour takes 200 of them."""
    assert not told(base=ONLINE)
    for key, stated, needed in (("fit", 199, 200), ("test", 500, 600)):
        (warning,) = told(f"study.healthy.{key}={stated}", base=ONLINE)
        assert warning.startswith(f"study.healthy.{key} = {stated} ")
        assert f"needs {needed} " in warning


BASE = """\
name: base
actuator: {piston_area: &area 2099 mm²}
indicators:
  flow_balance: {piston_area: *area, supply: nominal, supply_pressure: 160 bar}
supply: {pressure: 160 bar}
"""


def test_options_of_another_machine_are_found_also_by_an_alias_of_the_extended_file(tmp_path):
    def warnings(text):
        (tmp_path / "base.yaml").write_text(BASE)
        (tmp_path / "child.yaml").write_text("extends: base.yaml\nname: child\n" + text)
        found = hydrofdi.plan(tmp_path / "child.yaml").warnings
        return [each for each in found if "the options describe another machine: " in each]

    (warning,) = warnings("actuator: {piston_area: 1800 mm²}\nsupply: {pressure: 210 bar}\n")
    assert warning.startswith("flow_balance: ")
    assert "piston_area 2099 mm², but actuator.piston_area 1800 mm²" in warning
    assert "supply_pressure 160 bar, but supply.pressure 210 bar" in warning
    for text in (
        "",
        "actuator: {piston_area: 1800 mm²}\nindicators: {flow_balance: {piston_area: 1800 mm²}}\n",
        "valve: {natural_frequency: 90 Hz}\nindicators: {flow_balance: {natural_frequency: 175 Hz}}\n",
    ):
        assert not warnings(text)
    for name in (name for name in ready_names() if "/" not in name):
        assert not [*other_machines(load_experiment(name), None)]
