"""A study is swept like any experiment and read back population by population."""

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.evaluation.scores import Kind
from hydrofdi.execution import InProcessEngine
from hydrofdi.studies.reading import read_study

STUDY = """
name: small
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa}
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 6, test: 5, shift: 4, confusion: 3}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 4, fit: 2}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
  confusions: {worn friction: {friction.viscous: {uniform: [100, 200]}}}
detection: {false_alarm_rate: 20 %, indicators: [dwt, pressure_statistics]}
sweep: {grid: {record.sampling_frequency: [1 kHz, 500 Hz]}}
"""


@pytest.fixture(scope="module")
def designs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "study.yaml").write_text(STUDY)
    experiment = load_experiment(folder / "study.yaml")
    run_sweep(experiment, folder / "results", InProcessEngine())
    return read_study(read_results(folder / "results"))


def test_every_population_has_its_records(designs):
    for design in designs:
        records = design.records
        found = {(each.name, each.kind, each.is_fit): len(records.rows(each)) for each in records.populations}
        assert found == {
            ("healthy", Kind.HEALTHY, True): 6,
            ("healthy", Kind.HEALTHY, False): 5,
            ("0.2 L/min", Kind.FAULT, True): 2,
            ("0.2 L/min", Kind.FAULT, False): 4,
            ("1 L/min", Kind.FAULT, True): 2,
            ("1 L/min", Kind.FAULT, False): 4,
            ("stiffer", Kind.SHIFT, False): 4,
            ("worn friction", Kind.CONFUSION, False): 3,
        }


def test_designs_stand_in_the_order_of_the_sweep(designs):
    found = [design.records.design for design in designs]
    assert found == [{"record.sampling_frequency": 1000.0}, {"record.sampling_frequency": 500.0}]


def test_severity_is_the_true_mean_leak_of_each_record(designs):
    records = designs[0].records
    for population in records.populations:
        severity = records.severity[records.rows(population)]
        assert severity == pytest.approx(np.full_like(severity, population.severity), rel=0.1)
        assert len(np.unique(severity)) == (len(severity) if population.severity else 1)


def test_scores_are_the_single_numbers_of_the_judged_indicators(designs):
    names = [score.name for score in designs[0].scores]
    assert names[:2] == ["dwt.d1", "dwt.d2"]
    assert "pressure_statistics.kurtosis" in names
    assert all(len(score.values) == 30 for score in designs[0].scores)
    assert designs[0].scores[0].channels == ("chamber_1_pressure",)


def test_severity_can_be_the_level_that_was_asked_for(designs, tmp_path):
    (tmp_path / "study.yaml").write_text(STUDY.replace("each: 4,", "each: 4, severity: level,"))
    run_sweep(load_experiment(tmp_path / "study.yaml"), tmp_path / "results", InProcessEngine())
    records = read_study(read_results(tmp_path / "results"))[0].records
    nominal = np.array([population.severity for population in records.populations])
    np.testing.assert_array_equal(records.severity, nominal[records.of_record])
    assert (designs[0].records.severity != records.severity).any()
