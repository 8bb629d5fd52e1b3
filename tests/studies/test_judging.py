"""A score as a detector: what fit records set, and what test records say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.scores import Direction, Kind, Population
from hydrofdi.studies.judging import judge
from hydrofdi.studies.records import Scored, StudyRecords
from tests.evaluation.repeats import holds_at_least
from tests.studies.populations import FIT, LEVELS, PILOT, STIFFER, TEST, WORN, rising, study, usual

RULES = Rules()


def told(judgement):
    """All that is stated, as text: numbers to the last digit."""
    return repr(replace(judgement, scored=None, curve=None)) + repr(judgement.curve and judgement.curve.slope)


def test_shuffled_records_tell_nothing():
    records = usual()
    scored = rising(records)
    shuffled = np.random.default_rng(3).permutation(scored.values)
    judgement = judge(records, replace(scored, values=shuffled), RULES)
    assert sum(level.area.low <= 0.5 <= level.area.high for level in judgement.levels) >= 7
    assert judgement.smallest["q90_95"].value is None


def test_test_records_touch_neither_threshold_nor_direction():
    records = usual()
    scored = rising(records, direction=None)
    strange = scored.values.copy()
    for population in records.populations:
        if not population.is_fit:
            rows = records.rows(population)
            strange[rows] = -100.0 * strange[rows][::-1]
    plain, changed = (judge(records, replace(scored, values=v), RULES) for v in (scored.values, strange))
    assert plain.direction is changed.direction is Direction.RISING
    assert plain.threshold == changed.threshold
    assert plain.false_alarms != changed.false_alarms


def test_true_severities_touch_neither_threshold_nor_alarms_nor_areas():
    records = usual()
    scored = rising(records)
    poisoned = replace(records, severity=records.severity[::-1] + 7.0)
    plain, changed = judge(records, scored, RULES), judge(poisoned, scored, RULES)
    assert plain.threshold == changed.threshold
    assert plain.false_alarms == changed.false_alarms
    assert [(e.detected, e.area) for e in plain.levels] == [(e.detected, e.area) for e in changed.levels]
    assert plain.smallest != changed.smallest


@pytest.mark.parametrize("with_groups", [False, True])
def test_the_order_of_records_changes_nothing(with_groups):
    records = usual(healthy=300, each=40)
    if with_groups:
        groups = [str(number % 12) for number in range(records.severity.size)]
        records = replace(records, groups=groups)
    scored = rising(records, direction=None)
    order = np.random.default_rng(4).permutation(records.severity.size)
    mixed = replace(
        records,
        of_record=records.of_record[order],
        severity=records.severity[order],
        groups=[records.groups[row] for row in order] if with_groups else None,
    )
    plain = judge(records, scored, RULES)
    assert told(plain) == told(judge(mixed, replace(scored, values=scored.values[order]), RULES))


def test_falling_and_two_sided_scores_are_mirror_images():
    records = usual()
    scored = rising(records)
    fallen = replace(scored, values=-scored.values, direction=Direction.FALLING)
    plain, mirrored = judge(records, scored, RULES), judge(records, fallen, RULES)
    assert plain.threshold.high == -mirrored.threshold.low
    assert plain.false_alarms == mirrored.false_alarms
    assert plain.smallest == mirrored.smallest
    both = judge(records, replace(scored, direction=Direction.BOTH), RULES)
    assert np.isfinite([both.threshold.low, both.threshold.high]).all()
    assert both.levels[-1].area.value > 0.95


def test_a_leak_of_zero_is_detected_at_the_false_alarm_rate():
    nothing = Population("0", Kind.FAULT)
    records = study({FIT: 2000, TEST: 20_000, nothing: 20_000, **dict.fromkeys(LEVELS, 50)})
    judgement = judge(records, rising(records), RULES)
    false_alarms, detected = judgement.false_alarms[TEST], judgement.levels[0].detected
    assert judgement.levels[0].severity == 0.0
    assert abs(false_alarms.value - detected.value) < 0.005
    assert detected.low <= false_alarms.value <= detected.high
    assert judgement.curve.false_alarm_rate == false_alarms.value
    assert judgement.curve.tally.total.sum() == 9 * 50


def test_too_few_records_are_refused_with_the_number_needed():
    records = study({FIT: 30, TEST: 30, **dict.fromkeys(LEVELS[6:], 8)})
    judgement = judge(records, rising(records), RULES.model_copy(update={"threshold": "tolerance"}))
    assert judgement.threshold is None
    assert not judgement.false_alarms
    assert not judgement.smallest
    assert any("299 healthy records, not 30" in refusal for refusal in judgement.refusals)
    assert [level.detected for level in judgement.levels] == [None] * 3
    assert judgement.levels[-1].area.low > 0.5, "areas and their intervals are stated all the same"
    assert not judgement.keeps_its_rate


def test_few_detections_are_counted_and_show_no_severity():
    records = study({FIT: 300, TEST: 300, LEVELS[8]: 13, STIFFER: 100})
    judgement = judge(records, rising(records, slope=9.0), RULES)
    assert judgement.levels[0].detected.count == 13
    assert "q90_95" not in judgement.smallest
    assert any("needs 29 faulty records" in refusal for refusal in judgement.refusals)
    assert judgement.counted == {STIFFER: 299, LEVELS[8]: 29}


def test_a_step_is_stated_at_the_largest_true_severity_of_a_tested_level():
    records = study({FIT: 300, TEST: 1000, **dict.fromkeys(LEVELS, 40)}, spread=0.05)
    values = np.random.default_rng(5).normal(size=records.severity.size)
    values += 100.0 * (records.of_record >= records.populations.index(LEVELS[4]))
    judgement = judge(records, Scored("step", values, direction=Direction.RISING), RULES)
    assert judgement.curve.is_step
    bound = judgement.smallest["q90_95"]
    assert bound.severity == records.severity[records.rows(LEVELS[4])].max()
    assert (bound.place, bound.confidence) == ("within", 0.95)


@pytest.mark.parametrize("axis", ["log", "linear"])
def test_the_curve_rises_along_the_axis_of_the_score(axis):
    records = study({FIT: 1000, TEST: 1000, **dict.fromkeys(LEVELS, 200)})
    scored = rising(records, slope=4.0)
    if axis == "linear":
        values = np.random.default_rng(7).normal(size=records.severity.size) + 20.0 * records.severity
        scored = replace(scored, values=values)
    judgement = judge(records, scored, RULES)
    high = judgement.threshold.high
    truth = (high + norm.ppf(0.9)) / 20.0
    if axis == "log":
        truth = 0.1 * 10.0 ** ((high + norm.ppf(0.9) - 2.33) / 4.0)
    assert judgement.curve.axis.name == axis
    assert judgement.lack_of_fit > 0.05
    assert 0.95 * truth < judgement.smallest["q90_95"].severity < 1.15 * truth


def test_severities_within_one_level_give_no_slope():
    records = study({FIT: 300, TEST: 1000, **dict.fromkeys(LEVELS, 40)}, spread=0.02)
    draw = np.random.default_rng(5)
    blurred = records.severity * np.exp(0.02 * draw.normal(size=records.severity.size))
    values = draw.normal(size=blurred.size) + 9.0 * (blurred > LEVELS[4].severity)
    judgement = judge(records, Scored("steep", values, direction=Direction.RISING), RULES)
    assert not judgement.curve.is_step, "severities of one level lie on the rise"
    assert judgement.smallest["q90_95"].severity == records.severity[records.rows(LEVELS[5])].max()


def test_severities_that_are_drawn_over_decades_give_a_slope():
    drawn = Population("any", Kind.FAULT, severity=0.1)
    records = study({FIT: 300, TEST: 1000, drawn: 400}, spread=1.5)
    judgement = judge(records, rising(records), RULES)
    bound = judgement.smallest["q90_95"]
    assert bound.place == "within"
    assert bound.severity not in records.severity


def test_a_curve_that_does_not_describe_the_hits_is_not_used():
    records = study({FIT: 300, TEST: 300, **dict.fromkeys(LEVELS, 100)})
    values = np.random.default_rng(6).normal(size=records.severity.size)
    half = (records.severity > 0.03) & (np.arange(values.size) % 2 == 0)
    values += 10.0 * (half | (records.severity > 0.5))
    judgement = judge(records, Scored("two stairs", values, direction=Direction.RISING), RULES)
    assert judgement.lack_of_fit < 1e-3
    assert any("does not describe" in remark for remark in judgement.remarks)
    bound = judgement.smallest["q90_95"].severity
    assert bound in [records.severity[records.rows(level)].max() for level in LEVELS]
    assert 0.5 < bound < 0.7


@pytest.mark.parametrize("repeats", [60, pytest.param(600, marks=pytest.mark.long)])
def test_the_stated_severity_is_not_too_small(repeats):
    records, held = usual(healthy=1000, each=60), 0
    for repeat in range(repeats):
        judgement = judge(records, rising(records, slope=4.0, seed=repeat), RULES)
        high = judgement.threshold.high
        truth = 0.1 * 10.0 ** ((high + norm.ppf(0.9) - 2.33) / 4.0)
        held += judgement.smallest["q90_95"].severity >= truth
    assert holds_at_least(held, repeats, 0.9)


def test_alarms_in_place_of_detections_are_seen_on_healthy_records():
    records = usual()
    scored = rising(records)
    shifted = scored.values.copy()
    shifted[records.rows(TEST)] += 1.0
    judgement = judge(records, replace(scored, values=shifted), RULES)
    assert not judgement.keeps_its_rate
    assert judge(records, scored, RULES).keeps_its_rate
    warm = scored.values.copy()
    warm[records.rows(STIFFER)] += 1.0
    assert not judge(records, replace(scored, values=warm), RULES).keeps_its_rate
    confused = scored.values.copy()
    confused[records.rows(WORN)] += 5.0
    judgement = judge(records, replace(scored, values=confused), RULES)
    assert judgement.false_alarms[WORN].value > 0.9
    assert judgement.keeps_its_rate, "another fault is no healthy machine"


def test_records_without_a_score_are_no_alarms_and_those_with_a_fault_are_missed():
    records = usual()
    values = rising(records).values.copy()
    values[records.rows(LEVELS[8])[:40]] = np.nan
    values[records.rows(FIT)[:10]] = np.nan
    judgement = judge(records, Scored("s", values, direction=Direction.RISING), RULES)
    assert (judgement.levels[8].detected.total, judgement.levels[8].detected.not_measurable) == (100, 40)
    assert judgement.threshold.not_measurable == 10
    assert any("count as missed: 40 of 100 at '1'" in remark for remark in judgement.remarks)


def test_nothing_measurable_is_nothing_stated():
    records = usual()
    empty = Scored("s", np.full(records.severity.size, np.nan))
    judgement = judge(records, empty, RULES)
    assert judgement.threshold is None
    assert not judgement.smallest
    assert all(level.area is None for level in judgement.levels)


def test_a_severity_that_nobody_knows_gives_no_curve():
    records = usual()
    unknown = replace(records, severity=np.where(records.severity > 0.0, np.nan, 0.0))
    judgement = judge(unknown, rising(records), RULES)
    assert judgement.curve is None
    assert any("no faulty record has a known severity" in refusal for refusal in judgement.refusals)
    assert judgement.levels[8].detected.value > 0.9


def test_without_healthy_test_records_groups_are_left_out_in_turn():
    sizes = {FIT: 900, **dict.fromkeys(LEVELS, 40)}
    records = study(sizes)
    of_group = np.arange(records.severity.size) % 9
    records = replace(records, groups=[f"unit {number}" for number in of_group])
    scored = rising(records)
    judgement = judge(records, scored, RULES)
    assert judgement.false_alarms[FIT].total == 900
    assert judgement.false_alarms[FIT].n_group == 9
    odd = scored.values + 3.0 * (of_group == 0) * (records.of_record == 0)
    assert judge(records, replace(scored, values=odd), RULES).false_alarms[FIT].count > 60
    ungrouped = judge(replace(records, groups=None), scored, RULES)
    assert not ungrouped.false_alarms
    assert any("no healthy record was tested" in refusal for refusal in ungrouped.refusals)


def test_bounds_of_records_in_groups_come_from_levels():
    records = usual(each=60)
    alike = replace(records, groups=[str(number % 40) for number in range(records.severity.size)])
    plain, grouped = judge(records, rising(records), RULES), judge(alike, rising(records), RULES)
    assert plain.smallest["q90"] == grouped.smallest["q90"]
    levels = [records.severity[records.rows(level)].max() for level in LEVELS]
    assert grouped.smallest["q90_95"].severity in levels
    assert grouped.smallest["q90_95"].severity >= plain.smallest["q90_95"].severity


def test_few_groups_that_agree_show_nothing():
    records = usual(each=60)
    few = replace(records, groups=[str(number % 6) for number in range(records.severity.size)])
    judgement = judge(few, rising(records, slope=9.0), RULES)
    assert judgement.levels[-1].detected.count == 60
    assert "q90_95" not in judgement.smallest
    assert any(
        "q90/95 needs 29 groups of faulty records that agree; there are 6" in text
        for text in judgement.refusals
    )


def test_faulty_fit_records_are_never_tested():
    records = usual()
    scored = rising(records, direction=None)
    judgement = judge(records, scored, RULES)
    assert PILOT not in [level.population for level in judgement.levels]
    fallen = scored.values.copy()
    fallen[records.rows(PILOT)] *= -1.0
    assert judge(records, replace(scored, values=fallen), RULES).direction is Direction.FALLING


@pytest.mark.parametrize("tested", [0, 1, 200])
def test_a_rate_that_too_few_records_show_is_neither_kept_nor_broken(tested):
    records = usual(healthy=1000)
    few = records.rows(TEST)[tested:]
    kept = np.setdiff1d(np.arange(records.of_record.size), few)
    fewer = StudyRecords(records.populations, records.of_record[kept], records.severity[kept], "1")
    assert judge(records, rising(records), Rules()).keeps_its_rate is True
    assert judge(fewer, rising(fewer), Rules()).keeps_its_rate is None


def test_a_shift_without_a_score_leaves_the_rate_unknown():
    records = usual(healthy=1000)
    scored = rising(records)
    values = scored.values.copy()
    values[records.rows(STIFFER)] = np.nan
    assert judge(records, replace(scored, values=values), Rules()).keeps_its_rate is None
