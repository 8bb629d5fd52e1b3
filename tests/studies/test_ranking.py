"""The order of scores that find the same, or nothing."""

import numpy as np

from hydrofdi.evaluation.direction import Direction
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored
from hydrofdi.studies.rules import Rules
from tests.studies.populations import LEVELS, usual


def test_of_scores_that_find_nothing_the_one_that_detects_most_comes_first():
    """An area at the middle level may be large where no leak is detected."""
    records, draw = usual(), np.random.default_rng(8)
    often, seldom = draw.normal(size=(2, records.severity.size))
    often[records.rows(LEVELS[-1])[:70]] += 10.0
    seldom[records.rows(LEVELS[4])] += 1.5
    scores = [Scored(name, own, direction=Direction.RISING) for name, own in (("b", often), ("a", seldom))]
    detection = detect(records, scores, Rules())
    assert all(each.smallest["q90_95"].value is None for each in detection.judgements)
    assert [each.scored.name for each in detection.judgements] == ["b", "a"]
