"""The rule of the largest fall, and the scores that are made where nobody chose any."""

import numpy as np
import pytest

from hydrofdi.detectors.scores.configuration import ScoreConfig
from hydrofdi.studies.made_scores import made_scores
from hydrofdi.studies.records import Scored
from tests.studies.populations import FIT, TEST, usual


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
