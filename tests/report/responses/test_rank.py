"""Rank correlations: laws, coverage of their intervals, and what chance gives."""

import numpy as np
import pytest
from scipy.stats import spearmanr

from hydrofdi.report.intervals import LEAST_RUNS
from hydrofdi.report.responses import rank_correlation

N_RUN, N_REPEAT = 64, 500


def heteroscedastic(rng, n_run):
    """A feature whose scatter grows with the parameter: ρ is not that of a normal distribution."""
    parameter = rng.uniform(size=n_run)
    return parameter, parameter + parameter * rng.normal(size=n_run)


def bent(rng, n_run):
    """A feature that falls, then rises."""
    parameter = rng.uniform(-1.0, 1.0, size=n_run)
    return parameter, (parameter - 0.3) ** 2 + 0.05 * rng.normal(size=n_run)


@pytest.mark.parametrize("draw", [heteroscedastic, bent])
def test_the_interval_covers_the_true_value_in_95_percent_of_repeats(draw):
    rng = np.random.default_rng(1)
    true = spearmanr(*draw(rng, 200_000)).statistic
    found = [rank_correlation(*draw(rng, N_RUN)) for _ in range(N_REPEAT)]
    covered = np.mean([each.low <= true <= each.high for each in found])
    assert 0.92 <= covered <= 0.985


def test_chance_gives_more_than_its_bound_in_5_percent_of_permutations():
    rng = np.random.default_rng(2)
    parameter, feature = heteroscedastic(rng, N_RUN)
    clear = [rank_correlation(parameter, rng.permutation(feature)).is_clear for _ in range(N_REPEAT)]
    assert 0.025 <= np.mean(clear) <= 0.08


@pytest.mark.parametrize(("feature", "expected"), [(np.exp, 1.0), (lambda x: -(x**3), -1.0)])
def test_a_monotone_feature_has_rank_correlation_1(feature, expected):
    parameter = np.random.default_rng(3).uniform(size=30)
    found = rank_correlation(parameter, feature(parameter))
    assert found.value == pytest.approx(expected)
    assert found.low == pytest.approx(found.high)


def test_it_is_spearmans_with_ties_and_without_runs_that_lack_a_number():
    rng = np.random.default_rng(4)
    parameter, feature = rng.integers(0, 6, 50).astype(float), rng.integers(0, 6, 50).astype(float)
    expected = spearmanr(parameter[:40], feature[:40]).statistic
    feature[40:] = np.nan
    found = rank_correlation(parameter, feature)
    assert found.value == pytest.approx(expected)
    assert found.n_run == 40


@pytest.mark.parametrize("n_run", [LEAST_RUNS - 1, LEAST_RUNS])
def test_too_few_runs_and_constant_features_have_none(n_run):
    parameter = np.arange(float(n_run))
    assert np.isfinite(rank_correlation(parameter, parameter).value) == (n_run == LEAST_RUNS)
    assert np.isnan(rank_correlation(parameter, np.ones(n_run)).value)
