"""Scores side by side: ranking, the Pareto set, how many were tried; bounds from tested levels."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from hydrofdi.detectors.rules import Rules, ScoreConfig
from hydrofdi.evaluation.pod import Tally, interpolated_level
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies import records as parts
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judging import detectability
from hydrofdi.studies.reading import made_scores
from hydrofdi.studies.records import Notes, Part, Scored
from tests.evaluation.repeats import holds_at_least
from tests.studies.populations import FIT, LEVELS, TEST, rising, usual

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
    scores = [rising(records, half=0.1, name=f"s{number}", seed=number) for number in range(10)]
    first = detect(records, scores, RULES).judgements[0].smallest
    assert first["q90_95_of_all"].confidence == 1.0 - 0.05 / 10
    assert first["q90_95_of_all"].severity > first["q90_95"].severity
    (alone,) = detect(records, scores[:1], RULES).judgements
    assert "q90_95_of_all" not in alone.smallest


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


SEVERITIES = np.geomspace(0.005, 0.32, 7)
THRESHOLD = quantile_threshold(np.linspace(0.0, 1.0, 1000), 0.01, direction=Direction.RISING)


def found(outcomes, severities=None):
    severities = SEVERITIES[:, None] * np.ones(40) if severities is None else severities
    levels = [Part(2.0 * own, true, None) for own, true in zip(outcomes, severities, strict=True)]
    return detectability(levels, THRESHOLD, 0.01, Rules(), Notes())["smallest"]


def bound(*levels):
    """q90/95 of hits at levels 1, 2, …, without a curve."""
    tested = [
        Part(2.0 * np.array(own, float), np.full(len(own), 1.0 + n), None) for n, own in enumerate(levels)
    ]
    return parts.TestedLevels(tested, THRESHOLD).bound(0.9, 0.95)


def test_29_of_29_show_90_percent_with_95_percent_confidence_and_28_of_28_do_not():
    for outcomes, place in (
        ([1] * 29, "below"), ([1] * 28, "above"), ([0] + [1] * 45, "below"), ([0] + [1] * 44, "above")
    ):  # fmt: skip
        assert bound(outcomes).place == place
    assert bound([1] * 40, [0, 1] * 20, [1] * 40).severity == 3.0


def test_a_level_is_wrongly_shown_in_at_most_5_of_100_repeats():
    draw, rates = np.random.default_rng(18), np.array([[0.3], [0.85], [0.899], [0.93]])
    wrong = sum(bound(*(draw.random((4, 60)) < rates)).severity < 4.0 for _ in range(1000))
    assert wrong <= 50 + 20


def hits(*counts):
    return [np.r_[np.ones(count), np.zeros(40 - count)] for count in counts]


@pytest.mark.parametrize("below", [0, 2, 4, 16, 31, 35])
def test_more_hits_at_the_upper_level_do_not_worsen_the_bound(below):
    bounds = [found(hits(0, 0, below, above, 40, 40, 40))["q90_95"] for above in (37, 38, 39, 40)]
    assert all(bound.place == "within" for bound in bounds)
    assert np.all(np.diff([bound.severity for bound in bounds]) <= 1e-9)


def test_a_bound_says_whether_it_is_that_of_a_curve():
    apart, fitted = found(hits(0, 0, 0, 40, 40, 40, 40)), found(hits(0, 2, 15, 30, 39, 40, 40))
    assert [each.source for each in apart.values()] == ["levels"] * 3
    assert [each.source for each in fitted.values()] == ["curve"] * 3
    assert apart["q90_95"].severity == SEVERITIES[3]
    assert SEVERITIES[2] < apart["q50"].severity < apart["q90"].severity < SEVERITIES[3]


def test_estimates_between_levels_follow_the_isotonic_estimate():
    counted = Tally(np.array([0.1, 1.0]), np.array([10.0, 30.0]), np.array([40.0, 40.0]))
    assert interpolated_level(counted, probability=0.5).severity == pytest.approx(0.1 * 10.0**0.5)
    assert interpolated_level(counted, probability=0.9).place == "above"
    assert interpolated_level(counted, probability=0.2).place == "below"


@pytest.mark.parametrize("spread", [0.03, pytest.param(0.2, marks=pytest.mark.long), 0.5])
def test_the_bound_covers_steep_curves_between_levels(spread):
    draw, covered, step = np.random.default_rng(5), 0, np.log(2.0)
    for _ in range(40):
        half = np.log(SEVERITIES[3]) + draw.uniform(-0.5, 0.5) * step
        true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.015, (7, 40)))
        chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / (spread * step))
        bound = found((draw.random(chance.shape) < chance).astype(float), true)["q90_95"]
        truth = np.exp(half + spread * step * ndtri(0.89 / 0.99))
        covered += bound.value is None or bound.value >= truth
    assert holds_at_least(covered, 40, 0.93)


def rows(n_repeat, n_record=40, n_group=None):
    """What is found of curves of many places and slopes, at seven levels."""
    draw = np.random.default_rng(7)
    groups = None if n_group is None else [f"unit {k % n_group}" for k in range(n_record)]
    for _ in range(n_repeat):
        half, slope = draw.uniform(-5.0, -1.5), draw.uniform(0.02, 0.9)
        true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.015, (SEVERITIES.size, n_record)))
        chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / slope)
        outcomes = (draw.random(chance.shape) < chance).astype(float)
        levels = [Part(2.0 * own, severity, groups) for own, severity in zip(outcomes, true, strict=True)]
        yield detectability(levels, THRESHOLD, 0.01, Rules(), Notes(), 20)["smallest"]


@pytest.mark.parametrize("n_group", [None, 40])
def test_no_bound_is_below_the_estimates_beside_it(n_group):
    sources = set()
    for found in rows(50, n_group=n_group):
        names = [name for name in ("q50", "q90", "q90_95", "q90_95_of_all") if name in found]
        severities = [math.inf if found[name].value is None else found[name].value for name in names]
        assert severities == sorted(severities), found
        sources |= {(found["q90"].source, found["q90_95"].source)} if "q90_95" in found else set()
    assert len(sources) > 1
