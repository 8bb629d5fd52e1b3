"""Scores that are made of several numbers, or are changes: who teaches them, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules, ScoreConfig
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import changes_since_before, made_scores
from hydrofdi.studies.records import Scored, StudyRecords
from tests.studies.populations import FIT, TEST, usual

KINDS = ("mahalanobis", "one_class", "lda", pytest.param("logistic", marks=pytest.mark.long), "compensated")


@pytest.fixture(scope="module")
def records():
    return usual(300, 40)


@pytest.fixture(scope="module")
def measured(records):
    """Two numbers that a nuisance rules, one of which falls with the leak, and a number for itself."""
    draw, n_record = np.random.default_rng(5), records.of_record.size
    load, noise = draw.normal(size=n_record), 0.05 * draw.normal(size=(3, n_record))
    return (
        Scored("a.low", load - records.severity + noise[0], ("chamber_1_pressure",), "Pa", cost=0.1),
        Scored("a.high", load + noise[1], ("chamber_1_pressure", "piston_position"), "Pa", cost=0.1),
        Scored("b.part[0]", noise[2], ("input_voltage",), cost=0.2),
    )


def made(records, measured, kind, of=("a", "b"), by=()):
    if kind == "compensated" and not by:
        of, by = ("a.low",), ("a.high", "b")
    return list(made_scores(records, measured, {"made": ScoreConfig(kind=kind, of=list(of), by=list(by))}))


@pytest.mark.parametrize("kind", KINDS)
def test_a_leak_that_no_number_shows_alone_is_found_and_neither_tested_records_nor_shifts_teach(
    kind, records, measured
):
    """Shifts do not even if they are called fit."""
    (score,) = made(records, measured, kind)
    alone, together = (detect(records, scores, Rules()).judgements[0] for scores in (measured, [score]))
    assert alone.levels[-1].found.value < 0.2
    assert together.levels[-1].found.value > 0.95
    assert together.false_alarms[TEST].low < together.threshold.interval[1]
    is_fit = np.array([population.is_fit for population in records.populations])[records.of_record]
    draw = np.random.default_rng(6)
    others = [
        replace(each, values=np.where(is_fit, each.values, draw.normal(size=is_fit.size)))
        for each in measured
    ]
    called = tuple(
        replace(each, is_fit=each.is_fit or each.kind is Kind.SHIFT) for each in records.populations
    )
    (other,) = made(replace(records, populations=called), others, kind)
    np.testing.assert_array_equal(score.values[is_fit], other.values[is_fit])
    assert not np.any(score.values[~is_fit] == other.values[~is_fit])


def test_compensated_keeps_unit_and_direction_of_its_number_and_takes_several(records, measured):
    falling = [replace(each, direction=Direction.FALLING) for each in measured]
    scores = made(records, falling, "compensated", of=["a"], by=["a.high", "b.part"])
    assert [score.name for score in scores] == ["made.a.low", "made.a.high"]
    assert {(score.unit, score.direction) for score in scores} == {("Pa", Direction.FALLING)}
    assert np.isfinite(scores[1].values).all()


def test_what_the_fit_records_do_not_carry_is_said_and_not_scored(records, measured):
    holed = measured[2].values.copy()
    holed[::3] = np.nan
    (score,) = made(records, [*measured[:2], replace(measured[2], values=holed)], "lda")
    (without,) = made(records, measured[:2], "lda", of=["a"])
    np.testing.assert_array_equal(score.values, without.values)
    assert "b.part[0] is left out: too many fit records lack it." in score.note
    assert "input_voltage" not in score.channels
    own = np.where(records.of_record == records.populations.index(FIT), 2, records.of_record)
    empty = [replace(each, values=np.full_like(each.values, np.nan)) for each in measured]
    for few, numbers in ((replace(records, of_record=own), measured), (records, empty)):
        (score,) = made(few, numbers, "one_class")
        assert np.isnan(score.values).all()
        assert score.note


def test_changes_since_a_record_before_are_taken_where_the_name_says_so(records, measured):
    changes = [replace(each, name=f"{each.name} (change)", values=each.values**3) for each in measured]
    every = [*measured, *changes]
    raw, changed = (made(records, every, "lda", of=[of])[0].values for of in ("a", "a (change)"))
    np.testing.assert_array_equal(raw, made(records, measured, "lda", of=["a"])[0].values)
    assert not np.any(raw == changed)
    names = [each.name for each in made(records, every, "compensated", of=["a (change)"], by=["b"])]
    assert names == ["made.a.low (change)", "made.a.high (change)"]


def test_what_is_constant_in_an_actuator_hides_a_leak_but_not_its_change():
    """Records without one before have no change."""
    draw, sizes = np.random.default_rng(8), (400, 400, 400, 100)
    populations = (
        Population("healthy", Kind.HEALTHY, is_fit=True),
        Population("healthy", Kind.HEALTHY),
        Population("0.1", Kind.FAULT, severity=0.1),
        Population("before", Kind.BEFORE),
    )
    of_record = np.repeat(np.arange(4), sizes)
    actuator = np.concatenate([np.arange(size) for size in sizes])
    severity = np.where(of_record == 2, 0.1, 0.0)
    values = draw.normal(size=400)[actuator] + severity + 0.01 * draw.normal(size=of_record.size)
    records = StudyRecords(populations, of_record, severity, "1", tuple(map(str, actuator)))
    scored = Scored("score", values, direction=Direction.RISING)
    (change,) = changes_since_before(records, [scored])
    np.testing.assert_array_equal(np.isfinite(change.values), actuator < 100)
    plain, since = (judge(records, each, Rules(false_alarm_rate=0.05)) for each in (scored, change))
    assert plain.levels[0].found.value < 0.2
    assert since.levels[0].found.count == 100
    assert not list(changes_since_before(replace(records, groups=None), [scored]))
