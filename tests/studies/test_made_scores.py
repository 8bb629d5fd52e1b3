"""Scores of a study that are made of several numbers: who teaches them, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules, ScoreConfig, make_score
from hydrofdi.evaluation.scores import Direction, Kind
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.reading import made_scores, read_study
from hydrofdi.studies.records import Scored
from tests.studies.populations import FIT, TEST, stored, usual

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


@pytest.fixture(scope="module", params=KINDS)
def kind_and_score(request, records, measured):
    (score,) = made(records, measured, request.param)
    return request.param, score


def test_a_leak_that_no_number_shows_alone_is_found(kind_and_score, records, measured):
    _, score = kind_and_score
    alone, together = (detect(records, scores, Rules()).judgements[0] for scores in (measured, [score]))
    assert alone.levels[-1].detected.value < 0.2
    assert together.levels[-1].detected.value > 0.95
    assert together.false_alarms[TEST].low < together.threshold.interval[1]


def test_neither_tested_records_nor_shifts_teach(kind_and_score, records, measured):
    """Shifts do not even if they are called fit."""
    kind, score = kind_and_score
    is_fit = np.array([population.is_fit for population in records.populations])[records.of_record]
    draw = np.random.default_rng(6)
    others = [
        replace(each, values=np.where(is_fit, each.values, draw.normal(size=is_fit.size)))
        for each in measured
    ]
    populations = tuple(
        replace(each, is_fit=each.is_fit or each.kind is Kind.SHIFT) for each in records.populations
    )
    (other,) = made(replace(records, populations=populations), others, kind)
    np.testing.assert_array_equal(score.values[is_fit], other.values[is_fit])
    assert not np.any(score.values[~is_fit] == other.values[~is_fit])


def test_compensated_keeps_unit_and_direction_of_its_number_and_takes_several(records, measured):
    falling = [replace(each, direction=Direction.FALLING) for each in measured]
    scores = made(records, falling, "compensated", of=["a"], by=["a.high", "b.part"])
    assert [score.name for score in scores] == ["made.a.low", "made.a.high"]
    assert {(score.unit, score.direction) for score in scores} == {("Pa", Direction.FALLING)}
    assert np.isfinite(scores[1].values).all()


def test_a_number_that_many_fit_records_lack_is_left_out_with_a_note(records, measured):
    holed = measured[2].values.copy()
    holed[::3] = np.nan
    with_hole = [*measured[:2], replace(measured[2], values=holed)]
    (score,) = made(records, with_hole, "lda")
    (without,) = made(records, measured[:2], "lda", of=["a"])
    np.testing.assert_array_equal(score.values, without.values)
    assert "b.part[0] is left out: too many fit records lack it." in score.note
    assert "input_voltage" not in score.channels


def test_what_the_fit_records_do_not_carry_is_said_and_not_scored(records, measured):
    few = replace(
        records, of_record=np.where(records.of_record == records.populations.index(FIT), 2, records.of_record)
    )
    empty = [replace(each, values=np.full_like(each.values, np.nan)) for each in measured]
    for own, numbers in ((few, measured), (records, empty)):
        (score,) = made(own, numbers, "one_class")
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


STUDY = """
name: made
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa}
indicators: [dwt, pressure_statistics]
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 12, test: 4}
  faults: {leakage.internal_flow: [1 L/min], each: 2, fit: 8}
detection:
  indicators: [dwt]
  scores:
    unusual: {kind: mahalanobis, of: [pressure_statistics, dwt.d3]}
    leak: {kind: lda, of: [pressure_statistics.mean, pressure_statistics.kurtosis]}
    calm: {kind: compensated, of: [dwt], by: [pressure_statistics.kurtosis]}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("made"), STUDY)


def test_made_scores_are_judged_beside_the_indicators_that_are_chosen_and_the_usual_ones_if_asked(data):
    (design,) = read_study(data)
    names = [score.name for score in design.scores]
    assert not [name for name in names if name.startswith("pressure_statistics")]
    assert [name for name in names if not name.startswith("dwt.")] == [
        "unusual",
        "leak",
        *(f"calm.{name}" for name in names if name.startswith("dwt.")),
    ]
    for score in design.scores[-3:]:
        assert np.isfinite(score.values).all(), score.note
    detection = data.experiment.detection.model_copy(update={"usual_scores": True})
    asked = replace(data, experiment=data.experiment.model_copy(update={"detection": detection}))
    more = {score.name for score in read_study(asked)[0].scores}
    assert more - {*names} == {"mahalanobis(P1)", "lda(P1)", "largest_change(d1 … d5)"}


def test_test_records_are_scored_by_the_model_of_all_fit_records(data):
    (design,) = read_study(data)
    values = np.stack([data.columns[f"pressure_statistics.{name}"] for name in ("mean", "kurtosis")], axis=1)
    populations = [design.records.populations[each] for each in design.records.of_record]
    is_fit = np.array([each.is_fit for each in populations])
    is_faulty = np.array([each.severity > 0.0 for each in populations])
    model = make_score("lda").fit(values[is_fit], is_faulty[is_fit])
    found = next(score.values for score in design.scores if score.name == "leak")
    np.testing.assert_array_equal(found[~is_fit], model.score(values[~is_fit]))
    assert not np.any(found[is_fit] == model.score(values[is_fit]))
