"""Nuisances of a score: known spreads, known leaks."""

import numpy as np
import pytest
from scipy import optimize, stats

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.sensitivity import Response, relative_spread, rising

LEVELS = np.array([0.01, 0.1, 1.0])


@pytest.mark.parametrize("n_alone", [49, 200])
def test_the_interval_of_a_relative_spread_holds_what_is_true(n_alone):
    draw = np.random.default_rng(7)
    held = 0
    for _ in range(300):
        share = relative_spread(0.4 * draw.standard_normal(n_alone) + 3.0, draw.standard_normal(500))
        held += share.low <= 0.4 <= share.high
    assert held / 300 > 0.9


def test_a_spread_keeps_under_change_of_unit_and_without_failed_records():
    draw = np.random.default_rng(8)
    alone, together = draw.standard_normal(50), 2.0 * draw.standard_normal(400)
    share = relative_spread(alone, together)
    failed = relative_spread(np.concatenate((alone, [np.nan])), 2.0 + together)
    assert (failed.value, failed.n_record) == (pytest.approx(share.value), 50)
    with pytest.raises(NotStatedError, match="49 records"):
        relative_spread(alone[:48], together)
    with pytest.raises(NotStatedError, match="no spread"):
        relative_spread(alone, np.zeros(400))


def population(centre, n=400, seed=0, spread=0.01):
    return centre + spread * np.random.default_rng(seed).standard_normal(n)


def response(sign=1.0, **options):
    """A score that moves by the decades of the leak above 1 mL/min: 1, 2 and 3."""
    faulty = [sign * population(shift, seed=k + 1) for k, shift in enumerate((1.0, 2.0, 3.0))]
    return Response(sign * population(0.0), faulty, LEVELS, **options)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_nuisance_is_told_as_the_leak_that_moves_the_score_as_far(sign):
    """Nine in ten healthy scores lie within −2.25 … 1.35 of the middle; 1 is that of 0.01, 2 that of 0.1."""
    scores = sign * np.linspace(-2.45, 1.55, 4000)
    reach = response(sign).reach(scores, sign * population(0.0, seed=8))
    for fault, severity in ((reach.imitated, 10.0**-1.65), (reach.hidden, 10.0**-0.75)):
        assert fault.place == "within"
        assert fault.severity == pytest.approx(severity, rel=0.02)
        assert fault.low < severity < fault.high


def test_no_leak_is_told_outside_of_the_tested_ones():
    centre = population(0.0, seed=8)
    small, large = (response().reach(population(0.0, seed=9, spread=spread), centre) for spread in (0.1, 9.0))
    assert (small.imitated.place, small.imitated.severity) == ("below", 0.01)
    assert (small.imitated.low, small.imitated.high) == (0.0, 0.0)
    assert (large.hidden.place, large.hidden.severity) == ("above", 1.0)
    assert (large.hidden.low, large.hidden.high) == (np.inf, np.inf)


def test_a_median_that_falls_between_levels_is_made_monotone():
    """1, 3.2, 2.8 are 1, 3, 3: a shift of 2.6 is reached, one of 3.1 is not."""
    faulty = [population(shift, seed=k + 1) for k, shift in enumerate((1.0, 3.2, 2.8))]
    found = Response(population(0.0), faulty, LEVELS)
    for half_width, place in ((2.9, "within"), (3.4, "above")):
        scores = np.linspace(-half_width, half_width, 4000)
        assert found.reach(scores, population(0.0, seed=8)).imitated.place == place


def test_the_interval_of_an_equivalent_leak_holds_what_is_true():
    """Nine in ten of N(0, 0.8²) lie within ±1.316: decades above 1 mL/min."""
    truth, held = 10.0 ** (-3.0 + 0.8 * stats.norm.ppf(0.95)), 0
    for seed in range(100):
        draw = np.random.default_rng(seed)
        faulty = [shift + 0.8 * draw.standard_normal(100) for shift in (1.0, 2.0, 3.0)]
        found = Response(0.8 * draw.standard_normal(400), faulty, LEVELS, seed=seed)
        fault = found.reach(0.8 * draw.standard_normal(200), 0.1 * draw.standard_normal(100)).imitated
        held += fault.low <= truth <= fault.high
    assert held >= 88


def test_rising_sequences_are_those_of_isotonic_regression():
    rows = np.random.default_rng(11).standard_normal((50, 9))
    expected = [optimize.isotonic_regression(row).x for row in rows]
    np.testing.assert_allclose(rising(rows), expected, atol=1e-12)
