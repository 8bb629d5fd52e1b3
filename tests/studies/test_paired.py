"""Records of the same actuator before and after: what is constant in it does not count."""

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.run_table.expansion import expand_runs
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import changes_since_before
from hydrofdi.studies.records import Rules, Scored, StudyRecords

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


def rows(table, kind, is_fit=False, severity=0.0):
    roles = table.study
    (place,) = (
        place
        for place, each in enumerate(roles.populations)
        if (each.kind, each.is_fit, each.severity) == (kind, is_fit, severity)
    )
    return np.flatnonzero(roles.of_run == place)


def drawn(table, name, positions):
    return np.array(table.runs.values(name))[positions]


@pytest.mark.parametrize("is_fit", [True, False])
def test_every_actuator_that_is_judged_has_a_record_before(table, is_fit):
    before = rows(table, Kind.BEFORE, is_fit)
    assert len(before) == (3 if is_fit else 5)
    assert not drawn(table, "leakage.internal_coefficient", before).any()
    for kind, severity in ((Kind.HEALTHY, 0.0), (Kind.FAULT, 1e-9), (Kind.FAULT, 2e-9)):
        after = rows(table, kind, is_fit, severity)
        for name in ("fluid.bulk_modulus", "friction.scale"):
            np.testing.assert_array_equal(drawn(table, name, after), drawn(table, name, before)[: len(after)])
        seeds = [drawn(table, "measurement.seed", each) for each in (before[: len(after)], after)]
        assert (seeds[0] != seeds[1]).all()
        groups = table.study.actuators
        assert [groups[row] for row in after] == [groups[row] for row in before[: len(after)]]


def test_a_shift_changes_an_actuator_that_was_seen_before(table):
    before, after = rows(table, Kind.BEFORE), rows(table, Kind.SHIFT)
    np.testing.assert_array_equal(
        drawn(table, "friction.scale", after), drawn(table, "friction.scale", before)[: len(after)]
    )
    assert (drawn(table, "fluid.bulk_modulus", after) == 827e6).all()


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


def test_independent_records_have_no_changes():
    records, scored = paired()
    alone = StudyRecords(records.populations, records.of_record, records.severity, "1")
    assert not list(changes_since_before(alone, [scored]))
