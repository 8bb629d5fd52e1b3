"""The rule of the largest fall, and the scores that are made where nobody chose any."""

import numpy as np
import pytest

from hydrofdi.config.study.detection import ScoreConfig
from hydrofdi.evaluation.direction import Direction
from hydrofdi.studies.made_scores import made_scores
from hydrofdi.studies.records import Scored
from hydrofdi.studies.usual_scores import usual_scores
from tests.studies.populations import FIT, LEVELS, TEST, study, usual

DETAILS = [f"dwt.d{level}" for level in range(1, 6)]


def test_the_rule_of_the_largest_fall():
    records = study({FIT: 10, TEST: 1, LEVELS[0]: 1})
    levels = {"dwt.d1": [*([1.0, 3.0] * 5), 1.0, 2.0], "dwt.d2": [4.0] * 11 + [1.0]}
    scores = [Scored(name, np.array(values)) for name, values in levels.items()]
    (score,) = made_scores(records, scores, {"rule": ScoreConfig(kind="largest_change", of=["dwt"])})
    assert score.values[-2:].tolist() == [0.5, 0.75]
    assert score.direction is Direction.RISING


def test_the_rule_learns_from_healthy_fit_records_alone():
    records = usual(healthy=50, each=5)
    values = 10.0 + np.random.default_rng(1).normal(size=records.severity.size)
    strange = np.where(records.of_record == records.populations.index(FIT), values, -values)
    wanted = {"rule": ScoreConfig(kind="largest_change", of=["dwt.d1"])}
    (plain,), (changed,) = (
        made_scores(records, [Scored("dwt.d1", own)], wanted) for own in (values, strange)
    )
    fit = records.rows(FIT)
    assert np.array_equal(plain.values[fit], changed.values[fit])
    assert plain.values[records.rows(TEST)] == pytest.approx(
        1.0 - values[records.rows(TEST)] / values[fit].mean()
    )


def test_the_usual_scores_take_all_that_a_set_of_sensors_gives():
    records = usual(healthy=100, each=5)
    of_one, of_two = ("chamber_1_pressure",), ("chamber_1_pressure", "chamber_2_pressure")
    needs = {"kurtosis": of_one, "decay[0]": of_two, **dict.fromkeys(DETAILS, of_one)}
    scores = [Scored(name, np.zeros(records.severity.size), channels) for name, channels in needs.items()]
    chosen = {name: (made.kind, made.of) for name, made in usual_scores(records, scores).items()}
    assert chosen == {
        "mahalanobis(P1)": ("mahalanobis", ["kurtosis", *DETAILS]),
        "lda(P1)": ("lda", ["kurtosis", *DETAILS]),
        "mahalanobis(P1 P2)": ("mahalanobis", list(needs)),
        "lda(P1 P2)": ("lda", list(needs)),
        "largest_change(d1 … d5)": ("largest_change", DETAILS),
    }
    unlearned = usual_scores(study({FIT: 10}), scores[:2])
    assert list(unlearned) == ["mahalanobis(P1 P2)"]
