"""Nuisances of a score: known indices, known noise, known leaks."""

import numpy as np
import pytest
from scipy import optimize, stats
from scipy.stats import qmc

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.sensitivity.indices import sobol_indices
from hydrofdi.evaluation.sensitivity.response import Response, rising
from hydrofdi.evaluation.sensitivity.spread import relative_spread

LEVELS = np.array([0.01, 0.1, 1.0])


def pages(function, n_factor, n_base, seed, noise=0.0):
    """Scores at A, B, every A with a column of B, and A again, each record with its own noise."""
    cube = qmc.Sobol(2 * n_factor, rng=seed).random(n_base)
    first, second = cube[:, :n_factor], cube[:, n_factor:]
    exchanged = np.repeat(first[None], n_factor, axis=0)
    for factor in range(n_factor):
        exchanged[factor, :, factor] = second[:, factor]
    draw = np.random.default_rng(seed)

    def scores(points):
        return function(points) + noise * draw.standard_normal(len(points))

    return scores(first), scores(second), np.array([scores(page) for page in exchanged]), scores(first)


def ishigami(points):
    x = np.pi * (2.0 * points - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def additive(points):
    """Variances 1/12 × (9, 1, 0)."""
    return 3.0 * points[:, 0] + points[:, 1]


def values(estimates):
    return np.array([estimate.value for estimate in estimates])


def test_indices_of_ishigami_are_the_known_ones():
    indices = sobol_indices(*pages(ishigami, 3, 4096, seed=1))
    parts = np.array([0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0, 0.0])
    together = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = parts.sum() + together
    np.testing.assert_allclose(values(indices.first_order), parts / variance, atol=0.02)
    total = (parts + together * np.array([1.0, 0.0, 1.0])) / variance
    np.testing.assert_allclose(values(indices.total), total, atol=0.02)
    assert indices.noise.value == 0.0


def test_without_noise_the_indices_are_those_of_scipy():
    first, second, exchanged, again = pages(ishigami, 3, 64, seed=2)
    mine = sobol_indices(first, second, exchanged, again)
    scores = {"f_A": first[None], "f_B": second[None], "f_AB": exchanged[:, None]}
    theirs = stats.sobol_indices(func=scores, n=64)
    np.testing.assert_allclose(values(mine.first_order), theirs.first_order, rtol=1e-12)
    np.testing.assert_allclose(values(mine.total), theirs.total_order, rtol=1e-12)


def test_noise_gets_its_own_share_and_none_of_a_factor():
    """With a noise as large as the rest, the factors have 0.45, 0.05 and 0 of the variance."""
    noise = np.sqrt(10.0 / 12.0)
    indices = sobol_indices(*pages(additive, 3, 4096, seed=3, noise=noise))
    assert indices.noise.value == pytest.approx(0.5, abs=0.03)
    np.testing.assert_allclose(values(indices.first_order), [0.45, 0.05, 0.0], atol=0.05)
    np.testing.assert_allclose(values(indices.total), [0.45, 0.05, 0.0], atol=0.05)


def test_intervals_of_indices_hold_what_is_true():
    truth = np.array([0.72, 0.08, 0.0, 0.72, 0.08, 0.0, 0.2])
    noise = np.sqrt(0.25 * 10.0 / 12.0)
    held = np.zeros(truth.size)
    for seed in range(200):
        indices = sobol_indices(*pages(additive, 3, 128, seed, noise), n_draw=400)
        found = [*indices.first_order, *indices.total, indices.noise]
        held += [one.low <= share <= one.high for one, share in zip(found, truth, strict=True)]
    assert (held / 200 > 0.88).all(), held / 200


def test_a_missing_score_loses_its_base_point_alone():
    first, second, exchanged, again = pages(ishigami, 3, 64, seed=4, noise=0.5)
    keeps = np.arange(64) != 17
    without = sobol_indices(first[keeps], second[keeps], exchanged[:, keeps], again[keeps])
    exchanged[1, 17] = np.nan
    indices = sobol_indices(first, second, exchanged, again)
    assert indices.n_lost == 1
    assert indices.first_order == without.first_order
    assert indices.total == without.total


def test_indices_know_neither_unit_nor_zero_of_a_score():
    records = pages(ishigami, 3, 64, seed=5, noise=0.5)
    plain, scaled = sobol_indices(*records), sobol_indices(*(1e5 - 20.0 * scores for scores in records))
    np.testing.assert_allclose(values(plain.first_order), values(scaled.first_order), atol=1e-9)
    np.testing.assert_allclose(values(plain.total), values(scaled.total), atol=1e-9)


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
