"""Intervals of shares: they hold the truth as often as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

from hydrofdi.report.intervals import clustered_share, wilson_interval


@pytest.mark.parametrize(("count", "total"), [(0, 10), (3, 10), (10, 10), (69, 72), (1024, 2048)])
def test_independent_draws_have_the_interval_of_scipy(count: int, total: int) -> None:
    expected = binomtest(count, total).proportion_ci(0.95, method="wilson")
    assert wilson_interval(count / total, total) == pytest.approx((expected.low, expected.high), abs=1e-12)


@pytest.mark.parametrize("truth", [0.05, 0.5, 0.9])
@pytest.mark.parametrize("alike", [0.0, 0.5, 1.0])
def test_the_interval_covers_the_truth_however_alike_the_pairs_are(truth: float, alike: float) -> None:
    generator, repeats, n_pair = np.random.default_rng(3), 1500, 120
    covered = 0
    clusters = np.repeat(np.arange(n_pair), 2)
    for _ in range(repeats):
        first = generator.random(n_pair) < truth
        second = np.where(generator.random(n_pair) < alike, first, generator.random(n_pair) < truth)
        share = clustered_share(np.column_stack([first, second]).ravel(), clusters)
        covered += share.low <= truth <= share.high
    assert 0.93 < covered / repeats < 0.975


def test_pairs_that_agree_count_once() -> None:
    outcomes = np.repeat(np.arange(100) < 30, 2)
    share = clustered_share(outcomes, np.repeat(np.arange(100), 2))
    assert (share.count, share.total) == (60, 200)
    assert (share.low, share.high) == pytest.approx(wilson_interval(0.3, 99.0), abs=1e-3)


def test_no_draws_have_no_share() -> None:
    share = clustered_share(np.zeros(0, dtype=bool), [])
    assert share.total == 0
    assert np.isnan(share.value)
