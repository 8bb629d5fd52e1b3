"""Scores of several numbers, learned on fit records alone."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.studies.judging import judge
from hydrofdi.studies.learning import Made, learned_scores
from hydrofdi.studies.records import Scored
from hydrofdi.studies.rules import Rules
from hydrofdi.studies.usual_scores import usual_scores
from tests.studies.populations import FIT, LEVELS, TEST, rising, study, usual

PRESSURE, BOTH = ("chamber_1_pressure",), ("chamber_1_pressure", "chamber_2_pressure")


def features(records, nuisance=3.0):
    """Two numbers that a nuisance moves alike, and the leak only one of them; a third that nothing moves."""
    draw = np.random.default_rng(20)
    common = nuisance * draw.normal(size=records.severity.size)
    leak = rising(records, seed=21).values
    names = ["kurtosis.raw", "kurtosis.other", "decay[0]"]
    values = [leak + common, common + 0.3 * draw.normal(size=common.size), draw.normal(size=common.size)]
    channels = [PRESSURE, PRESSURE, BOTH]
    costs = [2e-3, 2e-3, 3e-3]
    return [
        Scored(name, own, needs, cost=cost)
        for name, own, needs, cost in zip(names, values, channels, costs, strict=True)
    ]


def made(records, scores, **chosen):
    return list(learned_scores(records, scores, chosen))


def test_a_compensated_number_finds_what_the_nuisance_hides():
    records = usual()
    scores = features(records)
    (compensated,) = made(records, scores, c=Made("compensated", ("kurtosis.raw",), ("kurtosis.other",)))
    raw, better = (judge(records, each, Rules()) for each in (scores[0], compensated))
    assert better.middle_area > raw.middle_area + 0.1
    assert compensated.channels == PRESSURE


def test_channels_and_costs_are_those_of_all_indicators_once():
    records = usual()
    (score,) = made(
        records, features(records), c=Made("compensated", ("kurtosis.raw",), ("kurtosis", "decay"))
    )
    assert score.channels == BOTH
    assert score.cost == pytest.approx(5e-3)
    several = made(records, features(records), c=Made("compensated", ("kurtosis",), ("decay",)))
    assert [each.name for each in several] == ["c(kurtosis.raw)", "c(kurtosis.other)"]


@pytest.mark.parametrize(
    "kind", ["mahalanobis", "one_class", "lda", "logistic", "compensated", "largest_change"]
)
def test_test_records_teach_nothing(kind):
    pytest.importorskip("sklearn")
    records = usual(healthy=200, each=20)
    scores = features(records)
    tested = np.isin(
        records.of_record, [records.populations.index(TEST), records.populations.index(LEVELS[3])]
    )
    strange = [replace(each, values=np.where(tested, 1e3 - each.values, each.values)) for each in scores]
    made_of = Made(kind, ("kurtosis.raw",), ("kurtosis.other",))
    if kind != "compensated":
        made_of = Made(kind, ("kurtosis", "decay"))
    (plain,), (changed,) = made(records, scores, s=made_of), made(records, strange, s=made_of)
    assert np.array_equal(plain.values[~tested], changed.values[~tested])
    assert not np.array_equal(plain.values[tested], changed.values[tested])
    relabelled = replace(records, severity=records.severity[::-1])
    (again,) = made(relabelled, scores, s=made_of)
    assert np.array_equal(plain.values, again.values)


def test_thresholds_of_learned_scores_keep_their_rate_on_fresh_records():
    pytest.importorskip("sklearn")
    records = study({FIT: 200, TEST: 4000})
    draw = np.random.default_rng(22)
    scores = [Scored(f"a.{number}", draw.normal(size=4200), PRESSURE) for number in range(60)]
    (score,) = made(records, scores, m=Made("mahalanobis", ("a",)))
    rate = judge(records, score, Rules(false_alarm_rate=0.05)).false_alarms[TEST]
    assert 0.02 < rate.value < 0.1


def test_the_rule_of_the_largest_fall():
    records = study({FIT: 2, TEST: 1, LEVELS[0]: 1})
    levels = [
        Scored("dwt.d1", np.array([1.0, 3.0, 1.0, 2.0])),
        Scored("dwt.d2", np.array([4.0, 4.0, 4.0, 1.0])),
    ]
    (score,) = made(records, levels, rule=Made("largest_change", ("dwt",)))
    assert score.values.tolist() == [50.0, 0.0, 50.0, 75.0]
    assert (score.unit, score.direction) == ("%", Direction.RISING)


def test_what_is_not_measured_is_a_mistake_and_too_few_records_a_note():
    records = study({FIT: 4, TEST: 4})
    scores = features(records)
    with pytest.raises(ConfigError, match="'kurtosi' is not measured"):
        made(records, scores, s=Made("mahalanobis", ("kurtosi",)))
    (few,) = made(records, scores, s=Made("compensated", ("kurtosis.raw",), ("decay",)))
    assert np.isnan(few.values).all()
    assert "needs 5 healthy fit records" in few.note


def test_the_usual_scores_take_all_that_a_set_of_sensors_gives():
    records = usual(healthy=100, each=5)
    scores = features(records)
    lost = scores[2].values.copy()
    lost[records.rows(FIT)[:5]] = np.nan
    chosen = usual_scores(records, [*scores, replace(scores[2], name="rare", values=lost)])
    assert chosen == {
        "mahalanobis(P1)": Made("mahalanobis", ("kurtosis.raw", "kurtosis.other")),
        "lda(P1)": Made("lda", ("kurtosis.raw", "kurtosis.other")),
        "mahalanobis(P1 P2)": Made("mahalanobis", ("kurtosis.raw", "kurtosis.other", "decay[0]")),
        "lda(P1 P2)": Made("lda", ("kurtosis.raw", "kurtosis.other", "decay[0]")),
    }
    details = [replace(scores[0], name=f"dwt.d{level}") for level in range(1, 6)]
    assert usual_scores(records, details)["largest_change(d1 … d5)"].of == tuple(d.name for d in details)
