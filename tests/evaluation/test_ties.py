"""Decisions at ties: no last bit of a float decides."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from hydrofdi.detectors.charts import delays
from hydrofdi.detectors.rules import Rules, make_chart
from hydrofdi.evaluation.pod import HitCount, interpolated_level, lack_of_fit, probability_of_detection
from hydrofdi.evaluation.rates import Area
from hydrofdi.evaluation.scores import Direction, Kind, Population, comparable
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.papers.maddahi2015.study import clustered_share, wilson_interval
from hydrofdi.report.responses import fifths
from hydrofdi.studies.judging import detectability
from hydrofdi.studies.records import Judgement, Notes, Outcome, Part, Scored, ranked
from tests.evaluation.test_pod import hits


def shaken(draw, values):
    """Values with other last bits."""
    return values * (1.0 + draw.choice([-1e-15, 0.0, 1e-15], np.shape(values)))


def test_comparable_numbers_differ_from_the_thirteenth_digit_on():
    values = np.array([0.0, 0.9, -2.0, 1e-300, 7e8, np.inf, -np.inf, np.nan])
    np.testing.assert_array_equal(comparable(shaken(np.random.default_rng(1), values)), comparable(values))
    np.testing.assert_allclose(comparable(values), values, rtol=1e-12)
    assert comparable(0.9 + 1e-11) > comparable(0.9)


@pytest.mark.parametrize("n_level", [9, 12, 25])
def test_the_last_bits_of_severities_and_of_a_curve_do_not_move_a_p_value(n_level):
    draw = np.random.default_rng(2)
    for n in range(10, 101, 10):
        severity = np.repeat(np.logspace(-2.0, 0.0, n_level), n)
        outcomes = hits(draw, severity)
        curve = probability_of_detection(severity, outcomes)
        other = probability_of_detection(shaken(draw, severity), outcomes)
        moved = replace(curve, intercept=shaken(draw, curve.intercept), slope=shaken(draw, curve.slope))
        for each in (other, moved):
            assert lack_of_fit(each) == pytest.approx(lack_of_fit(curve), rel=1e-9, nan_ok=True)


def test_a_pooled_rate_that_is_asked_for_is_reached():
    for percent, n, m in product((50, 80, 90), range(1, 41), range(1, 41)):
        hits, rest = divmod(percent * (n + m), 100)
        few = min(n, hits)
        if not rest and hits - few <= m:
            levels = HitCount(
                np.array([0.1, 0.2]), np.array([few, hits - few], float), np.array([n, m], float)
            )
            assert interpolated_level(levels, probability=percent / 100).place == "below"


def test_equal_scores_are_ranked_by_name():
    scores, level = np.arange(9.0), Population("leak", Kind.FAULT, severity=1.0)
    limit = quantile_threshold(scores, 0.3)

    def judged(name, area):
        outcome = Outcome(level, 1.0, None, Area(area, 0.0, 1.0, 9, 9))
        return Judgement(Scored(name, scores), Direction.RISING, limit, (outcome,))

    for last in np.arange(-3, 4) * 1.1e-16:
        both = ranked([judged("b", 0.7 + last), judged("a", 0.7)])
        assert [each.scored.name for each in both] == ["a", "b"]


def test_two_levels_have_a_curve_over_the_logarithm():
    """Both axes pass through two rates: their likelihoods are the same."""
    limit = quantile_threshold(np.linspace(0.0, 1.0, 200), 0.01)
    for n, floor, few, many in product(range(20, 50, 5), (0.0, 0.02), (2, 5, 8), (10, 14, 18)):
        levels = [Part(2.0 * (np.arange(n) < k), np.full(n, q), None) for k, q in ((few, 0.1), (many, 0.2))]
        assert detectability(levels, limit, floor, Rules(), Notes())["curve"].axis == "log"


def test_fifths_are_cut_by_rank():
    for n in range(6, 300, 5):
        values = np.random.default_rng(n).random(n)
        places = np.argmax([own for *_, own in fifths(values)], axis=0)
        assert places[np.argsort(values)].tolist() == [min(5 * k // (n - 1), 4) for k in range(n)]


def test_a_score_at_the_onset_is_after_it():
    instants, chart = np.cumsum(np.full(40, 0.1)), make_chart("cusum")
    for k in range(40):
        found = delays(chart, 4.0, np.full((1, 40), 0.0) + 9.0 * (np.arange(40) == k), instants, (k + 1) / 10)
        assert (found.n_early[0], found.values[0]) == (0, pytest.approx(0.0, abs=1e-9))


def test_last_bits_make_no_variance_between_clusters():
    for size in range(3, 60):
        outcomes, clusters = np.tile(np.arange(size) < 2, 10), np.repeat(np.arange(10), size)
        found = clustered_share(outcomes, clusters)
        assert (found.low, found.high) == wilson_interval(2 / size, 10.0)
