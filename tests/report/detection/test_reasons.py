"""What the first page says of every set of sensors, and of what is missing."""

from __future__ import annotations

import numpy as np
import pytest

from hydrofdi.evaluation.populations import Kind
from hydrofdi.report.detection.answer import answer_block
from hydrofdi.report.detection.selection import best_with_sensors
from hydrofdi.report.detection.wording import sensors
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import P1, P2, U, judged, made_up_records, made_up_score
from tests.report.rows import rows


def first_page(detection):
    block = answer_block(detection)
    return " ".join(block.paragraphs), block.tables[0]


@pytest.mark.parametrize("chosen", [{}, {"n_healthy": 200}, {"n_healthy": 20}])
def test_every_set_of_sensors_has_a_row(chosen):
    detection = judged(**chosen)
    _, sheet = first_page(detection)
    assert {row[0] for row in rows(sheet)} == {sensors(each) for each in detection.judgements}
    ranks = [
        next(rank for rank, each in enumerate(detection.judgements) if row[1].startswith(each.scored.name))
        for row in rows(sheet)
    ]
    best = ranks[: len({sensors(each) for each in detection.judgements})]
    assert best == sorted(best)


def test_the_best_score_has_a_row_if_its_false_alarms_are_unknown():
    detection = judged(n_healthy=200)
    text, sheet = first_page(detection)
    first = detection.judgements[0]
    assert first.keeps_its_rate is None
    assert f"{first.scored.name} finds" in text
    assert rows(sheet)[0][1].startswith(first.scored.name)


def study(*scores, **chosen):
    records = made_up_records(**chosen)
    return detect(records, [score(records) for score in scores], Rules())


def found(records):
    return made_up_score(records, "found", gain=200.0, channels=(P1, P2, U))


def test_a_score_exceeds_its_rate_where_its_interval_lies_above_what_is_allowed():
    for judgement in judged().judgements:
        allowed = judgement.threshold.interval[1]
        expected = [each for each, rate in judgement.false_alarms.items() if rate.low > allowed]
        assert list(judgement.exceeded) == expected
        is_shown = any(each.kind is not Kind.CONFUSION for each in expected)
        assert is_shown == (judgement.keeps_its_rate is False)
        assert np.isfinite(allowed)


def worse(records):
    return made_up_score(records, "worse", gain=3.0, seed=4, channels=(P1, P2, U))


def good(records):
    return made_up_score(records, "good", gain=200.0, seed=5, channels=(P1,))


def test_more_sensors_never_find_less():
    detection = study(good, worse)
    assert {each.scored.name for each in best_with_sensors(detection).values()} == {"good"}
    text, sheet = first_page(detection)
    assert [row[1] for row in rows(sheet)] == ["good"]
    assert "P2 and u would not help" in text
