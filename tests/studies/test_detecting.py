"""Scores side by side: ranking, the Pareto set, how many were tried; bounds from tested levels."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from hydrofdi.detectors.rules import Rules
from hydrofdi.evaluation.pod import HitCount, interpolated_level
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judging import TestedLevels as Levels
from hydrofdi.studies.judging import detectability
from hydrofdi.studies.records import Notes, Part, Scored
from tests.evaluation.repeats import holds_at_least
from tests.studies.populations import FIT, LEVELS, rising, usual

RULES = Rules()


def names(detection):
    return [judgement.name for judgement in detection.judgements]


def test_the_smallest_fault_comes_first_and_unkept_rates_last():
    records = usual()
    good, fair = rising(records, half=0.03, name="good"), rising(records, half=0.2, name="fair")
    noise = replace(good, name="noise", values=np.random.default_rng(7).normal(size=good.values.size))
    loud = good.values + 5.0 * (records.of_record != records.populations.index(FIT))
    always = replace(good, name="always", values=loud)
    detection = detect(records, [noise, always, fair, good], RULES)
    assert names(detection) == ["good", "fair", "noise", "always"]
    assert detection.judgements[-1].bound.value is not None
    assert names(detect(records, [good, noise, fair, always], RULES)) == names(detection)


def test_the_pareto_set_weighs_channels_against_severity():
    records = usual()
    scores = [
        rising(records, half=half, name=name, channels=tuple(name.split(",")[0].split()))
        for name, half in (
            ("p1 p2 u x", 0.02), ("p1 u", 0.1), ("p1 u, worse", 0.2), ("p1 u x, worse", 0.3), ("x", 0.25),
        )
    ]  # fmt: skip
    scores.append(rising(records, half=0.01, name="unknown"))
    assert detect(records, scores, RULES).pareto == {"p1 p2 u x", "p1 u", "x"}


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
    detection = detect(records, scores, RULES)
    assert all(each.bound.value is None for each in detection.judgements)
    assert names(detection) == ["b", "a"]


SEVERITIES = np.geomspace(0.005, 0.32, 7)
THRESHOLD = quantile_threshold(np.linspace(0.0, 1.0, 1000), 0.01, direction=Direction.RISING)


def found(outcomes, severities=None, groups=None, n_tried=1):
    severities = SEVERITIES[:, None] * np.ones(40) if severities is None else severities
    levels = [Part(2.0 * own, true, groups) for own, true in zip(outcomes, severities, strict=True)]
    return detectability(levels, THRESHOLD, 0.01, RULES, Notes(), n_tried)["smallest"]


def bound(*levels):
    """q90/95 of hits at levels 1, 2, …, without a curve."""
    parts = [Part(2.0 * np.array(own, float), np.full(len(own), n), None) for n, own in enumerate(levels, 1)]
    return Levels(parts, THRESHOLD).bound_of_levels(0.9, 0.95)


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
    counted = HitCount(np.array([0.1, 1.0]), np.array([10.0, 30.0]), np.array([40.0, 40.0]))
    assert interpolated_level(counted, probability=0.5).severity == pytest.approx(0.1 * 10.0**0.5)
    assert interpolated_level(counted, probability=0.9).place == "above"
    assert interpolated_level(counted, probability=0.2).place == "below"


def outcomes_of(draw, half, slope):
    """True severities near the levels, and hits of a curve over their logarithm."""
    true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.015, (7, 40)))
    chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / slope)
    return (draw.random(chance.shape) < chance).astype(float), true


@pytest.mark.parametrize("spread", [0.03, pytest.param(0.2, marks=pytest.mark.long), 0.5])
def test_the_bound_covers_steep_curves_between_levels(spread):
    draw, covered, step = np.random.default_rng(5), 0, np.log(2.0)
    for _ in range(40):
        half = np.log(SEVERITIES[3]) + draw.uniform(-0.5, 0.5) * step
        bound = found(*outcomes_of(draw, half, spread * step))["q90_95"]
        truth = np.exp(half + spread * step * ndtri(0.89 / 0.99))
        covered += bound.value is None or bound.value >= truth
    assert holds_at_least(covered, 40, 0.93)


@pytest.mark.parametrize("n_group", [None, 40])
def test_no_bound_is_below_the_estimates_beside_it(n_group):
    draw, sources = np.random.default_rng(7), set()
    groups = None if n_group is None else [f"unit {k % n_group}" for k in range(40)]
    for _ in range(50):
        outcomes = outcomes_of(draw, draw.uniform(-5.0, -1.5), draw.uniform(0.02, 0.9))
        smallest = found(*outcomes, groups, 20)
        names = [name for name in ("q50", "q90", "q90_95", "q90_95_of_all") if name in smallest]
        severities = [math.inf if smallest[name].value is None else smallest[name].value for name in names]
        assert severities == sorted(severities), smallest
        sources |= {(smallest["q90"].source, smallest["q90_95"].source)} if "q90_95" in smallest else set()
    assert len(sources) > 1
