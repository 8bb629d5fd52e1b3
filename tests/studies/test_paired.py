"""Records of studies: as stored, in pairs, and measured."""

from dataclasses import replace

import numpy as np
import pytest

import hydrofdi
from hydrofdi.config import load_experiment
from hydrofdi.config.runs import expand_runs
from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures
from hydrofdi.records import Channel
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import changes_since_before, measured_study, read_study
from hydrofdi.studies.records import Scored, StudyRecords
from tests.studies.populations import rows, stored

STUDY = """
name: paired
study:
  pairing: common
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}, friction.scale: {uniform: ±30 %}}}
  healthy: {fit: 3, test: 4, shift: 2}
  faults: {leakage.internal_coefficient: [1e-9, 2e-9], each: 5, fit: 2}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
"""


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    file = tmp_path_factory.mktemp("paired") / "study.yaml"
    file.write_text(STUDY)
    return expand_runs(load_experiment(file))


@pytest.mark.parametrize("is_fit", [True, False])
def test_every_actuator_that_is_judged_has_a_record_before(table, is_fit):
    before = rows(table, Kind.BEFORE, is_fit=is_fit)
    assert len(before) == (3 if is_fit else 5)
    values = {name: np.array(table.runs.values(name)) for name in NAMES}
    groups = table.study.actuators
    assert not values["leakage.internal_coefficient"][before].any()
    for kind, severity in ((Kind.HEALTHY, 0.0), (Kind.FAULT, 1e-9), (Kind.FAULT, 2e-9)):
        after = rows(table, kind, is_fit=is_fit, severity=severity)
        of_same = before[: len(after)]
        for name in ("fluid.bulk_modulus", "friction.scale"):
            np.testing.assert_array_equal(values[name][after], values[name][of_same])
        assert (values["measurement.seed"][after] != values["measurement.seed"][of_same]).all()
        assert [groups[row] for row in after] == [groups[row] for row in of_same]


def test_actuators_are_groups_of_which_fit_and_test_share_none_and_a_shift_changes_those_seen_before(table):
    modulus = np.array(table.runs.values("fluid.bulk_modulus"))
    before, after = rows(table, Kind.BEFORE), rows(table, Kind.SHIFT)
    assert not set(modulus[before]) & set(modulus[rows(table, Kind.BEFORE, is_fit=True)])
    friction = np.array(table.runs.values("friction.scale"))
    np.testing.assert_array_equal(friction[after], friction[before][: len(after)])
    assert (modulus[after] == 827e6).all()
    assert len(set(table.runs.values("measurement.seed"))) == len(table.runs), "noise is of each record"
    pairs = set(zip(table.study.actuators, friction, strict=True))
    assert len(pairs) == len(set(table.study.actuators)) == len(set(friction))


NAMES = ("fluid.bulk_modulus", "friction.scale", "measurement.seed", "leakage.internal_coefficient")


FIT, TEST = Population("healthy", Kind.HEALTHY, is_fit=True), Population("healthy", Kind.HEALTHY)
LEAK = Population("0.1", Kind.FAULT, severity=0.1)
BEFORE = Population("before", Kind.BEFORE)


def paired(n_actuator=400, n_before=400):
    """Scores with a large constant of each actuator, small noise of each record, and a leak of 0.1."""
    draw = np.random.default_rng(8)
    populations = {FIT: 400, TEST: 400, LEAK: 400, BEFORE: n_before}
    of_record = np.repeat(np.arange(4), list(populations.values()))
    groups = tuple(f"{place}" for size in populations.values() for place in range(size))
    constant = draw.normal(size=n_actuator)[[int(group) for group in groups]]
    severity = np.where(of_record == 2, 0.1, 0.0)
    values = constant + severity + 0.01 * draw.normal(size=of_record.size)
    records = StudyRecords(tuple(populations), of_record, severity, "1", groups)
    return records, Scored("score", values, direction=Direction.RISING)


def test_what_is_constant_in_an_actuator_hides_a_leak_but_not_its_change():
    records, scored = paired()
    (change,) = changes_since_before(records, [scored])
    plain, since = (judge(records, each, Rules(false_alarm_rate=0.05)) for each in (scored, change))
    assert plain.levels[0].detected.value < 0.2
    assert since.levels[0].detected.value == 1.0


def test_records_without_one_before_have_no_change():
    records, scored = paired(n_before=100)
    (change,) = changes_since_before(records, [scored])
    has_change = np.array([int(group) < 100 for group in records.groups])
    np.testing.assert_array_equal(np.isfinite(change.values), has_change)
    assert not list(changes_since_before(replace(records, groups=None), [scored]))


READING_STUDY = """
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
    return read_study(stored(tmp_path_factory.mktemp("study"), READING_STUDY))


def test_every_population_of_each_design_has_its_records_with_the_true_mean_leak_of_each(designs):
    found = [design.records.design for design in designs]
    assert found == [{"record.sampling_frequency": 1000.0}, {"record.sampling_frequency": 500.0}]
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
    text = READING_STUDY.replace("each: 4,", "each: 4, severity: level,")
    records = read_study(stored(tmp_path, text))[0].records
    nominal = np.array([population.severity for population in records.populations])
    np.testing.assert_array_equal(records.severity, nominal[records.of_record])
    assert (designs[0].records.severity != records.severity).any()


P1 = (Channel.CHAMBER_1_PRESSURE,)

COLUMNS = [
    MeasuredOutput("ring", Output("decay", "1/s", "decay", direction=Direction.RISING), "1/s", P1),
    MeasuredOutput("ring", Output("parts", "1", "shares", {"part": 2}), "1", P1),
    MeasuredOutput("ring", Output.quality("error", "1/s", "standard error"), "1/s", P1),
    MeasuredOutput("never", Output("there", "1", "nothing"), "1", P1),
]


def record(number, label, group="", rejected=False):
    values = {
        "ring.decay": np.array(number),
        "ring.parts": np.array([number, -number]),
        "ring.error": np.array(9.0),
    }
    place = f"r{number}", "here", group, label
    return RecordMeasures(*place, "ok", {} if rejected else values, {}, is_rejected=rejected)


def test_scores_are_the_numbers_that_any_record_has_and_that_speak_of_the_actuator():
    measured = [record(float(n + 1), label) for n, label in enumerate(["sound", "sound", "worn", ""])]
    study = measured_study(COLUMNS, [*measured, record(5.0, "worn", rejected=True)], ["sound"], {})
    assert {score.name: score.values.tolist() for score in study.scores} == {
        "ring.decay": [1.0, 2.0, 3.0],
        "ring.parts[0]": [1.0, 2.0, 3.0],
        "ring.parts[1]": [-1.0, -2.0, -3.0],
    }
    assert study.scores[0].direction is Direction.RISING
    assert study.scores[0].channels == ("chamber_1_pressure",)


def test_halves_without_groups_and_groups_as_they_are():
    def records(groups, of_worn):
        sound = [record(float(n), "sound", groups[n % len(groups)]) for n in range(20)]
        worn = record(99.0, "worn", of_worn)
        return measured_study(COLUMNS, [*sound, worn], ["sound"], {"worn": 5e-6}).records

    alone = records([""], "")
    sizes = {(p.name, p.kind, p.is_fit): alone.rows(p).size for p in alone.populations}
    assert sizes == {
        ("healthy (fit)", Kind.HEALTHY, True): 10,
        ("healthy", Kind.HEALTHY, False): 10,
        ("worn", Kind.FAULT, False): 1,
    }
    assert alone.severity.tolist() == [0.0] * 20 + [5e-6]
    grouped = records(["unit 0", "unit 1"], "unit 0")
    assert [(p.name, p.is_fit) for p in grouped.populations] == [("healthy", True), ("worn", False)]
    assert grouped.groups[-1] == "unit 0"
    assert not any("no group has both" in remark for remark in grouped.remarks)
    remarks = records(["unit 0"], "unit 1").remarks
    assert "only one healthy group" in remarks[0]
    assert "no group has both" in remarks[1]


def test_of_one_record_for_each_unit_it_cannot_be_told_whether_units_differ():
    noise = np.random.default_rng(1).standard_normal((6, 1000))
    noise[5] *= 9.0
    labels = {"label": ["sound"] * 5 + ["leaking"], "group": [f"unit {k}" for k in range(6)]}
    found = hydrofdi.evaluate(5e6 + 1e4 * noise, **labels, healthy="sound", sampling_frequency="1 kHz")
    assert {score["stands_clear"] for score in found.scores} == {None}
    assert found.conclusion
    (area,) = found.scores[0]["auc"]
    assert (area["value"], area["high"]) == (1.0, 1.0)
    assert area["low"] < 0.9
