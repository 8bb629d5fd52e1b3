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


def changed(scored, rows, change):
    """A score with other values in some rows."""
    values = scored.values.copy()
    values[rows] = change(values[rows])
    return replace(scored, values=values)


def steep(values):
    return Scored("made", values, direction=Direction.RISING)


def largest(records, population):
    """The largest true severity."""
    return records.severity[records.rows(population)].max()


def test_shuffled_records_tell_nothing():
    records = usual()
    shuffled = np.random.default_rng(3).permutation(rising(records).values)
    judgement = judge(records, steep(shuffled), RULES)
    assert sum(level.area.low <= 0.5 <= level.area.high for level in judgement.levels) >= 7
    assert judgement.bound.value is None


def test_test_records_touch_neither_threshold_nor_direction_and_faulty_fit_records_are_never_tested():
    records = usual()
    scored = rising(records, direction=None)
    is_fit = np.array([each.is_fit for each in records.populations])[records.of_record]
    strange = changed(scored, ~is_fit, lambda values: -100.0 * values[::-1])
    plain, moved = (judge(records, each, RULES) for each in (scored, strange))
    assert plain.direction is moved.direction is Direction.RISING
    assert plain.threshold == moved.threshold
    assert plain.false_alarms != moved.false_alarms
    assert PILOT not in [each.population for each in plain.outcomes]
    fallen = changed(scored, records.rows(PILOT), np.negative)
    assert judge(records, fallen, RULES).direction is Direction.FALLING


def test_true_severities_touch_neither_threshold_nor_alarms_nor_areas():
    records = usual()
    poisoned = replace(records, severity=records.severity[::-1] + 7.0)
    plain, moved = (judge(each, rising(records), RULES) for each in (records, poisoned))
    assert plain.threshold == moved.threshold
    assert [(e.found, e.area) for e in plain.outcomes] == [(e.found, e.area) for e in moved.outcomes]
    assert plain.smallest != moved.smallest


@pytest.mark.parametrize("with_groups", [False, True])
def test_the_order_of_records_changes_nothing(with_groups):
    records = usual(healthy=300, each=40)
    groups = np.array([str(number % 12) for number in range(records.severity.size)])
    scored = rising(records, direction=None)
    order = np.random.default_rng(4).permutation(records.severity.size)

    def ordered(rows):
        own = replace(
            records,
            of_record=records.of_record[rows],
            severity=records.severity[rows],
            groups=groups[rows].tolist() if with_groups else None,
        )
        return told(judge(own, replace(scored, values=scored.values[rows]), RULES))

    assert ordered(np.arange(order.size)) == ordered(order)


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
    false_alarms, detected = judgement.false_alarms[TEST], judgement.levels[0].found
    assert judgement.levels[0].severity == 0.0
    assert abs(false_alarms.value - detected.value) < 0.005
    assert detected.low <= false_alarms.value <= detected.high
    assert judgement.curve.false_alarm_rate == false_alarms.value
    assert judgement.curve.tally.total.sum() == 9 * 50


def test_too_few_records_are_refused_with_the_number_needed():
    records = study({FIT: 30, TEST: 30, **dict.fromkeys(LEVELS[6:], 8)})
    judgement = judge(records, rising(records), RULES.model_copy(update={"threshold": "tolerance"}))
    assert judgement.threshold is None
    assert any("299 healthy records, not 30" in refusal for refusal in judgement.refusals)
    assert [(each.population, each.found) for each in judgement.outcomes] == [(q, None) for q in LEVELS[6:]]
    assert judgement.levels[-1].area.low > 0.5, "areas and their intervals are stated all the same"
    assert (judgement.smallest, judgement.keeps_its_rate) == ({}, None)
    records = study({FIT: 300, TEST: 300, LEVELS[8]: 13, STIFFER: 100})
    judgement = judge(records, rising(records, slope=9.0), RULES)
    assert judgement.levels[0].found.count == 13
    assert judgement.bound is None
    assert any("needs 29 faulty records" in refusal for refusal in judgement.refusals)
    assert [each.population for each in judgement.outcomes if each.is_counted] == [STIFFER, LEVELS[8]]


@pytest.mark.parametrize("is_step", [True, False])
def test_a_slope_within_one_level_is_none_and_the_bound_is_the_largest_true_severity_of_a_level(is_step):
    records = study({FIT: 300, TEST: 1000, **dict.fromkeys(LEVELS, 40)})
    draw, reached = np.random.default_rng(5), LEVELS[4 if is_step else 5]
    blurred = records.severity * np.exp(0.02 * draw.normal(size=records.severity.size))
    rise = (
        records.of_record >= records.populations.index(LEVELS[4]) if is_step else blurred > LEVELS[4].severity
    )
    values = draw.normal(size=blurred.size) + (100.0 if is_step else 9.0) * rise
    judgement = judge(records, steep(values), RULES)
    assert judgement.curve.is_step == is_step
    assert judgement.bound.severity == largest(records, reached)
    assert (judgement.bound.place, judgement.bound.confidence) == ("within", 0.95)


@pytest.mark.parametrize("axis", ["log", "linear"])
def test_the_curve_rises_along_the_axis_of_the_score(axis):
    records = study({FIT: 1000, TEST: 1000, **dict.fromkeys(LEVELS, 200)})
    scored = rising(records, slope=4.0)
    if axis == "linear":
        scored = steep(np.random.default_rng(7).normal(size=records.severity.size) + 20.0 * records.severity)
    judgement = judge(records, scored, RULES)
    truth = (judgement.threshold.high + norm.ppf(0.9)) / 20.0
    if axis == "log":
        truth = 0.1 * 10.0 ** ((20.0 * truth - 2.33) / 4.0)
    assert judgement.curve.axis == axis
    assert judgement.lack_of_fit > 0.05
    assert 0.95 * truth < judgement.bound.severity < 1.15 * truth


def test_severities_that_are_drawn_over_decades_give_a_slope():
    records = study({FIT: 300, TEST: 1000, Population("any", Kind.FAULT, severity=0.1): 400}, spread=1.5)
    bound = judge(records, rising(records), RULES).bound
    assert bound.place == "within"
    assert bound.severity not in records.severity


def test_a_curve_that_does_not_describe_the_hits_is_not_used():
    records = study({FIT: 300, TEST: 300, **dict.fromkeys(LEVELS, 100)})
    values = np.random.default_rng(6).normal(size=records.severity.size)
    half = (records.severity > 0.03) & (np.arange(values.size) % 2 == 0)
    judgement = judge(records, steep(values + 10.0 * (half | (records.severity > 0.5))), RULES)
    assert judgement.lack_of_fit < 1e-3
    assert any("does not describe" in remark for remark in judgement.remarks)
    assert judgement.bound.severity in [largest(records, level) for level in LEVELS]
    assert 0.5 < judgement.bound.severity < 0.7


@pytest.mark.parametrize("repeats", [60, pytest.param(600, marks=pytest.mark.long)])
def test_the_stated_severity_is_not_too_small(repeats):
    records, held = usual(healthy=1000, each=60), 0
    for repeat in range(repeats):
        judgement = judge(records, rising(records, slope=4.0, seed=repeat), RULES)
        truth = 0.1 * 10.0 ** ((judgement.threshold.high + norm.ppf(0.9) - 2.33) / 4.0)
        held += judgement.bound.severity >= truth
    assert holds_at_least(held, repeats, 0.9)


def test_alarms_in_place_of_detections_are_seen_on_healthy_records():
    records = usual()
    scored = rising(records)

    def with_shift(population, shift):
        return judge(records, changed(scored, records.rows(population), lambda own: own + shift), RULES)

    assert judge(records, scored, RULES).keeps_its_rate is True
    assert with_shift(TEST, 1.0).keeps_its_rate is with_shift(STIFFER, 1.0).keeps_its_rate is False
    assert with_shift(STIFFER, np.nan).keeps_its_rate is None, "a shift without a score leaves it unknown"
    confused = with_shift(WORN, 5.0)
    assert confused.false_alarms[WORN].value > 0.9
    assert confused.keeps_its_rate, "another fault is no healthy machine"


@pytest.mark.parametrize("tested", [0, 1, 200])
def test_a_rate_that_too_few_records_show_is_neither_kept_nor_broken(tested):
    records = usual()
    kept = np.setdiff1d(np.arange(records.of_record.size), records.rows(TEST)[tested:])
    fewer = StudyRecords(records.populations, records.of_record[kept], records.severity[kept], "1")
    assert judge(fewer, rising(fewer), RULES).keeps_its_rate is None


def test_records_without_a_score_are_no_alarms_and_those_with_a_fault_are_missed():
    records = usual()
    rows = np.r_[records.rows(LEVELS[8])[:40], records.rows(FIT)[:10]]
    judgement = judge(records, changed(rising(records), rows, lambda own: own * np.nan), RULES)
    assert (judgement.levels[8].found.total, judgement.levels[8].found.not_measurable) == (100, 40)
    assert judgement.threshold.not_measurable == 10
    assert any("count as missed: 40 of 100 at '1'" in remark for remark in judgement.remarks)
    nothing = judge(records, Scored("s", np.full(records.severity.size, np.nan)), RULES)
    assert nothing.threshold is None
    assert not nothing.smallest
    assert all(level.area is None for level in nothing.levels)


def test_a_severity_that_nobody_knows_gives_no_curve():
    records = usual()
    unknown = replace(records, severity=np.where(records.severity > 0.0, np.nan, 0.0))
    judgement = judge(unknown, rising(records), RULES)
    assert judgement.curve is None
    assert any("no faulty record has a known severity" in refusal for refusal in judgement.refusals)
    assert judgement.levels[8].found.value > 0.9


def test_without_healthy_test_records_groups_are_left_out_in_turn():
    records = study({FIT: 900, **dict.fromkeys(LEVELS, 40)})
    of_group = np.arange(records.severity.size) % 9
    grouped = replace(records, groups=[f"unit {number}" for number in of_group])
    scored = rising(records)
    rate = judge(grouped, scored, RULES).false_alarms[FIT]
    assert (rate.total, rate.n_group) == (900, 9)
    odd = changed(scored, (of_group == 0) & (records.of_record == 0), lambda own: own + 3.0)
    assert judge(grouped, odd, RULES).false_alarms[FIT].count > 60
    ungrouped = judge(records, scored, RULES)
    assert not ungrouped.false_alarms
    assert any("no healthy record was tested" in refusal for refusal in ungrouped.refusals)


def test_bounds_of_records_in_groups_come_from_levels_and_few_groups_that_agree_show_nothing():
    records = usual(each=60)

    def in_groups(n_group, scored):
        groups = [str(number % n_group) for number in range(records.severity.size)]
        return judge(replace(records, groups=groups), scored, RULES)

    plain, grouped = judge(records, rising(records), RULES), in_groups(40, rising(records))
    assert plain.smallest["q90"] == grouped.smallest["q90"]
    assert grouped.bound.severity in [largest(records, level) for level in LEVELS]
    assert grouped.bound.severity >= plain.bound.severity
    few = in_groups(6, rising(records, slope=9.0))
    assert few.levels[-1].found.count == 60
    assert few.bound is None
    needed = "q90/95 needs 29 groups of faulty records that agree; there are 6"
    assert any(needed in text for text in few.refusals)
