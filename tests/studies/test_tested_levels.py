"""Bounds where hits and misses leave the slope open, and faulty records without a score."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from hydrofdi.evaluation.pod.tally import Tally, interpolated_level
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.judging import detectability, judge
from hydrofdi.studies.parts import Notes, Part
from hydrofdi.studies.records import Rules
from tests.evaluation.repeats import holds_at_least
from tests.studies.populations import LEVELS, rising, usual

SEVERITIES = np.geomspace(0.005, 0.32, 7)
THRESHOLD = quantile_threshold(np.linspace(0.0, 1.0, 1000), 0.01, direction=Direction.RISING)


def found(outcomes, severities=None):
    severities = SEVERITIES[:, None] * np.ones(40) if severities is None else severities
    levels = [Part(2.0 * own, true, None) for own, true in zip(outcomes, severities, strict=True)]
    return detectability(levels, THRESHOLD, 0.01, Rules(), Notes()).smallest


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


@pytest.mark.parametrize("spread", [0.03, 0.2, 0.5])
def test_the_bound_covers_steep_curves_between_levels(spread):
    from scipy.special import ndtr, ndtri

    draw, covered, step = np.random.default_rng(5), 0, np.log(2.0)
    for _ in range(60):
        half = np.log(SEVERITIES[3]) + draw.uniform(-0.5, 0.5) * step
        true = SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.015, (7, 40)))
        chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / (spread * step))
        bound = found((draw.random(chance.shape) < chance).astype(float), true)["q90_95"]
        truth = np.exp(half + spread * step * ndtri(0.89 / 0.99))
        covered += bound.value is None or bound.value >= truth
    assert holds_at_least(covered, 60, 0.93)


def test_faulty_records_without_a_score_are_missed():
    records = usual()
    scored = rising(records, slope=9.0)
    values, lost = scored.values.copy(), records.rows(LEVELS[-1])[:30]
    values[lost] = np.nan
    judgement = judge(records, replace(scored, values=values), Rules())
    level = judgement.levels[-1].detected
    assert (level.count, level.total, level.not_measurable) == (70, 100, 30)
    assert judgement.smallest["q90_95"].value is None
    assert any("30 of 100 at '1'" in remark for remark in judgement.remarks)


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
        yield detectability(levels, THRESHOLD, 0.01, Rules(n_tried=20), Notes()).smallest


@pytest.mark.parametrize("n_group", [None, 40])
def test_no_bound_is_below_the_estimates_beside_it(n_group):
    sources = set()
    for found in rows(150, n_group=n_group):
        names = [name for name in ("q50", "q90", "q90_95", "q90_95_of_all") if name in found]
        severities = [math.inf if found[name].value is None else found[name].value for name in names]
        assert severities == sorted(severities), found
        sources |= {(found["q90"].source, found["q90_95"].source)} if "q90_95" in found else set()
    assert len(sources) > 1


MISS_SEVERITIES = np.geomspace(0.001, 1.0, 7)
STEP = np.log(MISS_SEVERITIES[1] / MISS_SEVERITIES[0])


def miss_found(outcomes, true):
    """What is found, and the remarks."""
    levels, notes = [Part(2.0 * own, at, None) for own, at in zip(outcomes, true, strict=True)], Notes()
    return detectability(levels, THRESHOLD, 0.01, Rules(), notes).smallest, " ".join(notes.remarks)


def drawn(draw, spread, n_record=60):
    """Hits of a steep curve at seven levels, their true severities, and the true q90."""
    half = np.log(MISS_SEVERITIES[3]) + draw.uniform(-0.5, 0.5) * STEP
    true = MISS_SEVERITIES[:, None] * np.exp(draw.normal(0.0, 0.02, (MISS_SEVERITIES.size, n_record)))
    chance = 0.01 + 0.99 * ndtr((np.log(true) - half) / (spread * STEP))
    truth = np.exp(half + spread * STEP * ndtri(0.89 / 0.99))
    return (draw.random(chance.shape) < chance).astype(float), true, truth


@pytest.mark.parametrize("spread", [0.1, 0.2])
def test_their_bound_covers_the_truth_as_often_as_promised(spread):
    draw, covered, repeats = np.random.default_rng(11), 0, 0
    while repeats < 40:
        outcomes, true, truth = drawn(draw, spread)
        smallest, remarks = miss_found(outcomes, true)
        bound = smallest["q90_95"]
        if bound.source == "curve" and "fewer than two tested levels" in remarks:
            repeats += 1
            covered += bound.value is None or bound.value >= truth
    assert holds_at_least(covered, repeats, 0.95)
