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


def first_page(detection):
    block = answer_block(detection)
    return " ".join(block.paragraphs), block.tables[0]


@pytest.mark.parametrize("chosen", [{}, {"n_healthy": 200}, {"n_healthy": 20}])
def test_every_set_of_sensors_has_a_row(chosen):
    detection = judged(**chosen)
    _, sheet = first_page(detection)
    assert {row[1].text for row in sheet.rows} == {sensors(each) for each in detection.judgements}
    ranks = [
        next(
            rank for rank, each in enumerate(detection.judgements) if row[0].text.startswith(each.scored.name)
        )
        for row in sheet.rows
    ]
    best = ranks[: len({sensors(each) for each in detection.judgements})]
    assert best == sorted(best)


def test_the_best_score_has_a_row_if_its_false_alarms_are_unknown():
    detection = judged(n_healthy=200)
    text, sheet = first_page(detection)
    first = detection.judgements[0]
    assert first.keeps_its_rate is None
    assert f"{first.scored.name} finds" in text
    assert sheet.rows[0][0].text.startswith(first.scored.name)


def study(*scores, **chosen):
    records = made_up_records(**chosen)
    return detect(records, [score(records) for score in scores], Rules())


def found(records):
    return made_up_score(records, "found", gain=200.0, channels=(P1, P2, U))


def noise(records):
    return made_up_score(records, "noise", gain=0.0, seed=2, channels=(P1,))


def alarming(records):
    return made_up_score(records, "alarming", gain=50.0, shift=9.0, seed=3, channels=(P1,))


def on_both_sides(records):
    return made_up_score(records, "on_both_sides", gain=50.0, seed=4, channels=(P1,), direction=None)


def test_sensors_that_find_nothing_are_named():
    assert "With P1 alone, no score finds anything up to 1 L/min." in first_page(study(found, noise))[0]
    text = first_page(study(found, noise, alarming))[0]
    assert "With P1 alone, no score that keeps to its false-alarm rate finds anything up to 1 L/min." in text
    text = first_page(study(found, alarming))[0]
    assert "With P1 alone, every score exceeds its false-alarm rate." in text


def test_a_bound_above_the_largest_nominal_level_is_explained():
    def late(records):
        return made_up_score(records, "late", gain=3.55, channels=(P1,))

    detection = study(late, n_other=300)
    assert detection.judgements[0].smallest["q90_95"].value > 1.0 / 6e4
    assert (
        "Records of the largest level, 1 L/min, have a true mean leakage of up to 1.1"
        in first_page(detection)[0]
    )
    assert "true mean leakage of up to" not in first_page(study(found))[0]


def test_scores_without_a_threshold_are_counted_with_the_remedy():
    text = first_page(study(found, on_both_sides, n_healthy=150))[0]
    assert "1 of 2 scores has no threshold for 1 % false alarms: 150 healthy records set it, 199" in text
    assert "set study.healthy.fit to 199, and study.healthy.test to 299 (150 now) to measure" in text
    assert "threshold for" not in first_page(study(found, on_both_sides, n_healthy=199))[0]


def test_the_shift_in_which_a_wavelet_rule_exceeds_its_rate_is_named():
    def rule(records):
        return made_up_score(records, "dwt.d2", gain=50.0, shift=9.0, channels=(P1,))

    text = first_page(study(found, rule))[0]
    assert "(and exceeds its false-alarm rate in 'stiffer' and 'much stiffer')" in text


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
    assert [row[0].text.split()[0] for row in sheet.rows] == ["good"]
    assert "Knowing P2 and u as well does not help P1." in text
