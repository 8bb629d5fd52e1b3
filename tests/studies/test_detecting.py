"""Scores side by side: ranking, the Pareto set, and how many were tried."""

from dataclasses import replace

import numpy as np

from hydrofdi.evaluation.direction import Direction
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored
from hydrofdi.studies.rules import Rules
from tests.studies.populations import FIT, rising, usual

RULES = Rules()


def names(detection):
    return [judgement.scored.name for judgement in detection.judgements]


def test_the_smallest_fault_comes_first_and_unkept_rates_last():
    records = usual()
    good, fair = rising(records, half=0.03, name="good"), rising(records, half=0.2, name="fair")
    noise = Scored(
        "noise", np.random.default_rng(7).normal(size=good.values.size), (), direction=Direction.RISING
    )
    loud = good.values + 5.0 * (records.of_record != records.populations.index(FIT))
    always = replace(good, name="always", values=loud)
    detection = detect(records, [noise, always, fair, good], RULES)
    assert names(detection) == ["good", "fair", "noise", "always"]
    assert detection.judgements[-1].smallest["q90_95"].value is not None
    assert names(detect(records, [good, noise, fair, always], RULES)) == names(detection)


def test_the_pareto_set_weighs_channels_against_severity():
    records = usual()
    scores = [
        rising(records, half=0.02, name="four", channels=("p1", "p2", "u", "x")),
        rising(records, half=0.1, name="two", channels=("p1", "u")),
        rising(records, half=0.2, name="two, worse", channels=("p1", "u")),
        rising(records, half=0.3, name="three, worse", channels=("p1", "u", "x")),
        rising(records, half=0.25, name="one", channels=("x",)),
        rising(records, half=0.01, name="unknown"),
    ]
    assert detect(records, scores, RULES).pareto == {"four", "two", "one"}


def test_the_number_of_scores_tried_widens_the_bound_of_the_best():
    records = usual()
    scores = [rising(records, half=0.1, name=f"s{number}", seed=number) for number in range(40)]
    first = detect(records, scores, RULES).judgements[0].smallest
    assert first["q90_95_of_all"].confidence == 1.0 - 0.05 / 40
    assert first["q90_95_of_all"].severity > first["q90_95"].severity
    (alone,) = detect(records, scores[:1], RULES).judgements
    assert "q90_95_of_all" not in alone.smallest
